"""The smoke test of an adapter: probes that any engine solves, and what explains a wrong answer."""
