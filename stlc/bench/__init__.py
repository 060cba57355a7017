"""Benchmarks: what to solve, each solve in its own process, a store of finished runs, reports."""
