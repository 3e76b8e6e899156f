"""`tendond doctor`: what is wrong with a rig before it is armed; each check is a function and a line of the table."""
