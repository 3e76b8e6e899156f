"""Moving the target by hand: a streamed speed, bounded, that is zero without a newer one."""
