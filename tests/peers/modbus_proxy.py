"""A faulty proxy between a Modbus TCP client and its server: modbus_proxy.py SERVER_PORT

Prints its port, and the system's time in us when it executes an order. Reads the orders from standard input, one per line: good | loss % |
delay MS | twice % | flip % | number (wrong transaction ids) | exception | half | reset | hang. They apply to the server's answers (reset,
hang: to the connection)."""
import random, select, socket, struct, sys, threading, time

dice = random.Random(1)
mode, value = "good", 0.0
listener = socket.create_server(("127.0.0.1", 0))


def listen_to_orders():
    global mode, value
    for line in sys.stdin:
        words = line.split()
        begun_us = time.time_ns() // 1000
        mode, value = words[0], float(words[1]) if len(words) > 1 else 0.0
        print(begun_us, flush=True)


def frame(sock):
    """Returns one whole frame, None at the end."""
    head = b""
    while len(head) < 6:
        more = sock.recv(6 - len(head))
        if not more:
            return None
        head += more
    body, size = b"", struct.unpack(">H", head[4:])[0]
    while len(body) < size:
        more = sock.recv(size - len(body))
        if not more:
            return None
        body += more
    return head + body


def answers(data):
    """Returns the parts of an answer to send on."""
    chance = dice.uniform(0, 100) < value
    if mode == "loss":
        return [] if chance else [data]
    if mode == "delay":
        time.sleep(value / 1000)
    if mode == "twice" and chance:
        return [data, data]
    if mode == "flip" and chance:
        at = dice.randrange(8, len(data))
        return [data[:at] + bytes([data[at] ^ 1 << dice.randrange(8)]) + data[at + 1:]]
    if mode == "number":
        return [struct.pack(">H", (struct.unpack(">H", data[:2])[0] + 1) & 0xFFFF) + data[2:]]
    if mode == "exception":
        return [data[:4] + b"\0\3" + data[6:7] + bytes([data[7] | 0x80, 4])]
    if mode == "half":
        return [data[:len(data) // 2]]
    return [data]


def carry(client, server):
    while True:
        ready = select.select([client, server], [], [], 0.02)[0]
        if mode == "reset":
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            return
        if mode == "hang":
            time.sleep(0.02)  # select() does not wait for unread data
            continue
        for sock in ready:
            data = frame(sock)
            if data is None:
                return
            for piece in [data] if sock is client else answers(data):
                (server if sock is client else client).sendall(piece)


threading.Thread(target=listen_to_orders, daemon=True).start()
print(listener.getsockname()[1], flush=True)
while True:
    client, _ = listener.accept()
    try:
        server = socket.create_connection(("127.0.0.1", int(sys.argv[1])))
        for sock in (client, server):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        carry(client, server)
        server.close()
    except OSError:
        pass
    client.close()
