"""The emulated servos against the manual: its tables as data, a host that knows neither SDK nor emulator."""
