class Plant:
    def __init__(self, field, parameters, seed):
        self.eye = field.writer("moved.eyes")

    def step(self, now_ns, dt_ns):
        self.eye(now_ns > 5_000_000)
