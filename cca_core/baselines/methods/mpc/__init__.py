"""Model predictive control: linear time-varying and nonlinear, planned once or in closed loop."""
