"""Greedy clients beside the master: modbus_greedy.py PORT. Prints "ready" when each has attacked once; continues
until standard input closes, then prints how often each attacked."""
import random, socket, sys, threading, time

port = int(sys.argv[1])
rounds = {}
over = threading.Event()


def connect():
    return socket.create_connection(("127.0.0.1", port), timeout=10)


def garbage(dice):
    with connect() as c:
        for _ in range(10):
            c.sendall(dice.randbytes(1 + dice.randrange(500)))


def idle(dice):
    clients = [connect() for _ in range(12)]
    over.wait(0.02)
    for c in clients:
        c.close()


def half(dice):
    whole = b"\0\1\0\0\0\x1b\1\x17\0\x1f\0\x1c\0\x17\0\x09\x12" + bytes(18)
    with connect() as c:
        c.sendall(whole[:1 + dice.randrange(len(whole) - 1)])
        over.wait(0.02)


def reconnect(dice):
    for _ in range(20):
        connect().close()


def flood(dice):
    """Sends requests and reads nothing until it is disconnected."""
    with connect() as c:
        while not over.is_set():
            c.sendall(b"\0\1\0\0\0\6\1\3\0\0\0\x3b" * 100)


def live(does):
    dice = random.Random(does.__name__)
    while not over.is_set():
        try:
            does(dice)
        except OSError:
            pass
        rounds[does.__name__] = rounds.get(does.__name__, 0) + 1
        over.wait(0.05)


threads = [threading.Thread(target=live, args=(does,)) for does in (garbage, idle, half, reconnect, flood)]
for thread in threads:
    thread.start()
while len(rounds) < len(threads):
    time.sleep(0.01)
print("ready", flush=True)
sys.stdin.read()
over.set()
for thread in threads:
    thread.join()
print("rounds:", ", ".join("%s %d" % item for item in sorted(rounds.items())), flush=True)
