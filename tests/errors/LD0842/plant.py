class Plant:
    def __init__(self, field, parameters, seed):
        self.eye = field.writer("%IX0.0")
        self.left = 15

    def step(self, now_ns, dt_ns):
        self.left -= 1
        self.eye(self.share() > 2)

    def share(self):
        return 15 / self.left
