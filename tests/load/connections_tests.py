"""Ten thousand open connections, none of which behaves, and good clients meanwhile.

    python3 -m unittest discover --start-directory tests/load --pattern '*_tests.py'

TERRAIN_ARCHIVE is the archive, TERRAIN_SERVER another program than target/release/terrain-server, CONNECTIONS how many. Needs wrk, and
as many open files for each process (ulimit -n).
"""

import contextlib
import json
import os
import pathlib
import re
import resource
import socket
import tempfile
import threading
import time
import unittest

from load import asked_by_wrk
from programs import get, terrain_server

COUNT = int(os.environ.get("CONNECTIONS", "10000"))
GOOD = 16
SECONDS = 20
# Longer than all of it takes, so that no connection ends before its time.
TIMEOUTS = ("--header-timeout", "300", "--write-timeout", "300", "--stop-within", "1")


class ManyConnections(unittest.TestCase):
    def test_good_clients_are_answered_while_ten_thousand_idle_trickle_and_read_slowly(self):
        raise_limit(COUNT + 100)
        options = ("--max-connections", str(COUNT + 1000), *TIMEOUTS)
        with tempfile.TemporaryDirectory(prefix="load-") as name, terrain_server(os.environ["TERRAIN_ARCHIVE"], *options) as (server, address):
            home, [path] = pathlib.Path(name), roots(address)
            expected = get(address + path)
            alone = asked_by_wrk(address, [path], home, GOOD, SECONDS // 4)
            with bad_clients(address, path, COUNT) as trickled:
                self.assertTrue(wait_until(address, lambda count: count >= COUNT), "all are accepted")
                among = asked_by_wrk(address, [path], home, GOOD, SECONDS)
                self.assertEqual(get(address + path), expected)
                self.assertGreaterEqual(open_connections(address), COUNT, "none was closed")
                memory = resident(server.pid)
            print(
                f"\n{COUNT} connections, {trickled()} bytes trickled: {memory} MB; {GOOD} good clients: "
                f"{alone['requests']:.0f} requests a second alone, {among['requests']:.0f} among them; "
                f"p50 {alone['p50']:.2f} and {among['p50']:.2f} ms, p99 {alone['p99']:.2f} and {among['p99']:.2f} ms"
            )
            self.assertEqual(among["failed"], 0)
            self.assertLess(among["p99"], 1000, "milliseconds")
            self.assertLess(memory, 1500, "MB")
            self.assertTrue(wait_until(address, lambda count: count < 10), "connections that are left end")


def raise_limit(files):
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard < files:
        raise unittest.SkipTest(f"only {hard} files may be open here")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, files), hard))


def roots(address):
    """Path of the first tile of the archive's first zoom."""
    [tileset] = json.loads(get(f"{address}/tilesets"))
    [zoom, *_] = tileset["metadata"]["zooms"]
    [west, south, *_] = zoom["available"][0]
    return [f"/{tileset['name']}/{zoom['zoom']}/{west}/{south}.terrain?v={tileset['version']}"]


@contextlib.contextmanager
def bad_clients(address, path, count):
    """A third idles after an answer, a third sends a head byte by byte, a third asks for much and reads some bytes a second."""
    host, port = address.removeprefix("http://").split(":")
    request = f"GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n".encode()
    head = f"GET {path} HTTP/1.1\r\nHost: {host}\r\nX-Slow: ".encode()
    sockets = []
    for number in range(count):
        one = socket.socket()
        # As few bytes as can be on the way, so that it is the server that waits.
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        one.connect((host, int(port)))
        one.sendall([request, head, request * 60][number % 3])
        one.setblocking(False)
        sockets.append(one)
    trickling, reading = sockets[1::3], sockets[2::3]
    done, sent = threading.Event(), [0]

    def go_on():
        while not done.wait(1.0):
            for one in trickling:
                with contextlib.suppress(OSError):
                    sent[0] += one.send(b"x")
            for one in reading:
                with contextlib.suppress(OSError):
                    one.recv(64)

    thread = threading.Thread(target=go_on)
    thread.start()
    try:
        yield lambda: sent[0]
    finally:
        done.set()
        thread.join()
        for one in sockets:
            one.close()


def open_connections(address):
    return int(re.search(rb"^terrain_connections (\d+)", get(f"{address}/metrics"), re.MULTILINE)[1])


def wait_until(address, is_right):
    for _ in range(100):
        if is_right(open_connections(address)):
            return True
        time.sleep(0.1)
    return False


def resident(process):
    text = pathlib.Path(f"/proc/{process}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", text)[1]) // 1024


if __name__ == "__main__":
    unittest.main()
