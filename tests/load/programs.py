"""A terrain-server and an nginx on this machine, each until it is left."""

import contextlib
import os
import pathlib
import signal
import socket
import subprocess
import time
import urllib.request

TOP = pathlib.Path(__file__).resolve().parents[2]
SERVER = os.environ.get("TERRAIN_SERVER", str(TOP / "target/release/terrain-server"))


@contextlib.contextmanager
def terrain_server(archive, *options):
    """Its process and its address."""
    port = free_port()
    command = [SERVER, str(archive), "--listen", f"127.0.0.1:{port}", *options]
    with running(command, port) as process:
        yield process, f"http://127.0.0.1:{port}"


@contextlib.contextmanager
def nginx(folder, home):
    """Its process and its address. Files ending in .terrain are sent as they are, as what gzip made, with the headers that terrain-server gives."""
    port = free_port()
    configuration = home / "nginx.conf"
    configuration.write_text(configuration_of(folder, home, port))
    with running(["nginx", "-e", "stderr", "-p", str(home), "-c", str(configuration)], port) as process:
        yield process, f"http://127.0.0.1:{port}"


def configuration_of(folder, home, port):
    temporary = "".join(f"{kind}_temp_path {home}/{kind};" for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
    user = "user root;" if os.getuid() == 0 else ""
    return f"""
daemon off; pid {home}/pid; {user} worker_processes {os.cpu_count()};
events {{ worker_connections 4096; }}
http {{
    {temporary}
    access_log off; sendfile on; tcp_nopush on; keepalive_requests 1000000000;
    open_file_cache max=10000 inactive=600s; open_file_cache_valid 600s;
    types {{ application/vnd.quantized-mesh terrain; }}
    server {{
        listen 127.0.0.1:{port}; root {folder};
        location / {{
            add_header Content-Encoding gzip;
            add_header Access-Control-Allow-Origin *;
            add_header Cache-Control "public, max-age=31536000, immutable";
            add_header Vary "accept, accept-encoding";
        }}
    }}
}}
"""


@contextlib.contextmanager
def running(command, port):
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        wait_until_open(process, port)
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait()


def wait_until_open(process, port):
    for _ in range(200):
        if process.poll() is not None:
            raise SystemExit(f"{process.args[0]} ended with {process.returncode}")
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
            return
        time.sleep(0.05)
    raise SystemExit(f"{process.args[0]} does not answer")


def processor_seconds(process):
    """Of a process and its children so far: of the programs themselves, and of the system for them."""
    children = subprocess.run(["pgrep", "--parent", str(process.pid)], capture_output=True, text=True).stdout.split()
    own = system = 0
    for number in [process.pid, *children]:
        fields = pathlib.Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
        own, system = own + int(fields[11]), system + int(fields[12])
    return [ticks / os.sysconf("SC_CLK_TCK") for ticks in (own, system)]


def free_port():
    with socket.socket() as place:
        place.bind(("127.0.0.1", 0))
        return place.getsockname()[1]


def get(address, **headers):
    """The body as it was sent, compressed or not."""
    request = urllib.request.Request(address, headers={name.replace("_", "-"): value for name, value in headers.items()})
    with urllib.request.urlopen(request) as answer:
        return answer.read()
