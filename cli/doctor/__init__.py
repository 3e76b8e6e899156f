"""`tendond doctor`: diagnosis of a rig before it is armed; each check is a function and a line of the table."""
