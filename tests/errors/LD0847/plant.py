import time


class Plant:
    def __init__(self, field, parameters, seed):
        pass

    def step(self, now_ns, dt_ns):
        time.sleep(0.5)
