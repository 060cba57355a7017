"""Teams that minimise effort: what each agent does alone, as bound and start."""
