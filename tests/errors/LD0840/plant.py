class Plant:
    def __init__(self, field, parameters, seed):
        self.eye = field.writer("%IX0.0")
        self.stroke = parameters["stroke"]

    def step(self, now_ns, dt_ns):
        self.eye(now_ns > self.stroke)
