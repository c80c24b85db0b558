"""The motor prior: intents (14 numbers) to 28 servo targets, a reference generator with balance and a learned
residual."""
