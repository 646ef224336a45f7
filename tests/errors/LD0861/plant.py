class Plant:
    def __init__(self, field, parameters, seed):
        self.silent = set()

    def step(self, now_ns, dt_ns):
        self.silent = {1} if 50_000_000 <= now_ns < 53_000_000 else set()
