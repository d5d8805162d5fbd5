"""The sources of the dashboards: one module for each, and shared parts."""
