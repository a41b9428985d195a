"""The paper's scenarios, and what a scenario is made of."""
