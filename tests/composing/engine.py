"""The container engine: a running one, or a private one that is stopped after the check."""

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

from .programs import programs

# Time limit for the daemon's start and stop, s.
DAEMON_PATIENCE_S = 60


def run(*command, **options):
    """Runs a command that must succeed. Returns its output as text."""
    ended = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)
    if ended.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))} ended with {ended.returncode}:\n{ended.stdout}{ended.stderr}")
    return ended.stdout


def client_with_buildkit():
    """Folder of a docker client with BuildKit, which is built in before version 23 and a plug-in later."""
    for folder in os.environ["PATH"].split(os.pathsep):
        client = Path(folder, "docker")
        if not os.access(client, os.X_OK):
            continue
        if subprocess.run([client, "buildx", "version"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0:
            return folder
        version = run(client, "--version").removeprefix("Docker version ").split(".")[0]
        if version.isdigit() and int(version) < 23:
            return folder
    raise RuntimeError("no docker client with BuildKit: install docker.io of Debian 12, or docker-buildx beside a newer one")


def answers():
    """Whether a container engine is running."""
    return subprocess.run(["docker", "info"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0


class Engine:
    """A context manager. It stops a daemon that it has started; the daemon's files are in the given folder."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.daemon = None

    def __enter__(self):
        os.environ["PATH"] = client_with_buildkit() + os.pathsep + os.environ["PATH"]
        os.environ["DOCKER_BUILDKIT"] = "1"
        if answers():
            print("using the running container engine", flush=True)
            return self
        socket = self.folder / "docker.sock"
        os.environ["DOCKER_HOST"] = f"unix://{socket}"
        log = open(self.folder / "dockerd.log", "w")
        self.daemon = subprocess.Popen(
            ["dockerd", "--data-root", self.folder / "docker", "--exec-root", self.folder / "exec",
             "--pidfile", self.folder / "docker.pid", "--host", f"unix://{socket}"],
            stdout=log, stderr=log,
        )
        deadline = time.monotonic() + DAEMON_PATIENCE_S
        while not answers():
            if self.daemon.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError("dockerd did not start:\n" + (self.folder / "dockerd.log").read_text()[-3000:])
            time.sleep(0.2)
        print("started dockerd with a private folder", flush=True)
        return self

    def __exit__(self, *_):
        if self.daemon is None or self.daemon.poll() is not None:
            return
        self.daemon.send_signal(signal.SIGTERM)
        try:
            self.daemon.wait(DAEMON_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.daemon.kill()
            self.daemon.wait()


class Images:
    """Stand-ins for the images of the stack, under private tags. `remove` deletes all of them."""

    def __init__(self, folder, prefix, binaries, archives):
        self.folder, self.prefix, self.binaries, self.archives = Path(folder), prefix, Path(binaries), Path(archives)
        self.made = []

    def tag(self, name):
        return f"{self.prefix}-{name}:check"

    def make(self):
        here = Path(__file__).parent / "standins"
        for name in ("debian", "servers"):
            run("docker", "import", self.archives / f"{name}.tar", self.tag(name))
            self.made.append(self.tag(name))
        context = self.folder / "standins"
        shutil.copytree(here, context)
        (context / "prebuilt").mkdir()
        for program in programs():
            shutil.copy(self.binaries / program, context / "prebuilt")
        for name in ("rust", "mosquitto", "postgres", "prometheus", "grafana"):
            run("docker", "build", "--quiet", "--target", name, "--tag", self.tag(name), "--build-arg",
                f"DEBIAN={self.tag('debian')}", "--build-arg", f"SERVERS={self.tag('servers')}", context)
            self.made.append(self.tag(name))

    def remove(self):
        subprocess.run(["docker", "image", "rm", "--force", *self.made], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
