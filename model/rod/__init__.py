"""The paper's rod: parameters, statics, time steps, tip, sensitivities, and what follows from them."""
