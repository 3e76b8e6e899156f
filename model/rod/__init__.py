"""The paper's rod: parameters, statics, time steps, tip, sensitivities, predictions."""
