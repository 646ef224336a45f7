class Plant:
    def __init__(self, field, parameters, seed):
        self.eye, self.lamp = field.writer("%IX0.0"), field.reader("%QX0.0")

    def step(self, now_ns, dt_ns):
        self.eye(now_ns > 25_000_000)
        if now_ns > 50_000_000:
            self.wait_until(False)

    def wait_until(self, value):
        while self.lamp() != value: pass
