"""A peer in a process of its own, to be killed: subscribes reliably and commands 60 kPa to joint 0 for ever."""

import time

from peers import Joint, Peer

with Peer("other") as peer:
    joint = Joint(peer)
    joint.wait_until_connected()
    print("connected", flush=True)
    while True:
        joint.command(60, 60, 60, 60)
        time.sleep(0.01)
