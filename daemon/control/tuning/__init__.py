"""Live tuning: gains and limits that change while the controller runs, bounded in rate."""
