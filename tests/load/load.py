"""wrk, and what it says."""

import re
import subprocess

# Each thread of wrk asks for all paths in turn.
SCRIPT = """
local requests = {}
local number = 0
function init(arguments)
  for path in io.lines(arguments[1]) do
    requests[#requests + 1] = wrk.format("GET", path, { ["Accept-Encoding"] = "gzip" })
  end
end
function request()
  number = number % #requests + 1
  return requests[number]
end
"""
UNITS = {"us": 1e-3, "ms": 1.0, "s": 1e3, "m": 6e4}


def asked_by_wrk(address, paths, home, connections, seconds, threads=1):
    """Requests a second, milliseconds that half and 99 of 100 answers took at most, and answers that failed."""
    script, list_of_paths = home / "paths.lua", home / "paths.txt"
    script.write_text(SCRIPT)
    list_of_paths.write_text("".join(f"{path}\n" for path in paths))
    command = ["wrk", "--latency", f"-t{threads}", f"-c{connections}", f"-d{seconds}s", "-s", script, address, "--", list_of_paths]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return {
        "requests": float(found(r"Requests/sec:\s+([\d.]+)", text)),
        "p50": milliseconds(text, "50"),
        "p99": milliseconds(text, "99"),
        "failed": sum(int(number) for number in failures(text)),
    }


def found(pattern, text):
    match = re.search(pattern, text)
    if match is None:
        raise SystemExit(f"wrk said something else than expected:\n{text}")
    return match[1]


def milliseconds(text, share):
    number, unit = re.search(rf"{share}%\s+([\d.]+)(us|ms|s|m)\b", text).groups()
    return float(number) * UNITS[unit]


def failures(text):
    lines = re.findall(r"(?:Socket errors|Non-2xx or 3xx responses):.*", text)
    return re.findall(r"\d+", " ".join(lines).replace("Non-2xx or 3xx", ""))
