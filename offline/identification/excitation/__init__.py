"""Safe excitation of a rig: the plan, its dry run in lockstep, and its recording on the rig."""
