"""The study of contacts: seeded runs on robots unlike the model, with a force anywhere on the body, or none."""
