class plant:
    def step(self, now_ns, dt_ns):
        pass
