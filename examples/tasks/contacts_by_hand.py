"""No robot, contacts given by hand: two rubber pads hold a plate whose weight of 1 N hangs 5 mm beside them."""

import handlcp as hl

rubber = hl.SoftFinger(0.5, mu_torsion=0.01)  # a patch bears 10 mN·m about its normal for each newton
pads = [hl.Contact((-0.01, 0, 0), normal=(1, 0, 0), friction=rubber),
        hl.Contact((0.01, 0, 0), normal=(-1, 0, 0), friction=rubber)]  # fmt: skip
grasp = hl.Grasp(pads, wrench=(0, 0, -1.0, 0.005, 0, 0), flexibility=1e-4, preload=1e-3)

solution = grasp.solve()
print(solution)
print("the least friction that would do:", grasp.required_friction())
