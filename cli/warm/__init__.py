"""`tendond warm`: the kernels compiled before they are needed."""
