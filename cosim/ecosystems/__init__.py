"""Systems of FMUs in the tools of others: an environment for agents that learn, a function for studies."""
