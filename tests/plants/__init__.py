"""Plants by others: simulators that share nothing with tendond's model, to hold the controller to."""
