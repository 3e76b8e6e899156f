"""The live view in the terminal: what has been seen on the bus, and how it is drawn. No bus and no clock in here."""
