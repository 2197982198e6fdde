"""A real browser without a screen, driven through Chrome's remote protocol."""

import base64
import itertools
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
import urllib.request

from drake_geom_ros.common.children import ends_with_parent

PATIENCE = 100.0  # [s] a software renderer on a busy machine
RESTING = 0.3  # [s] in which what rests stays where it is
PROGRAM = next(filter(None, map(shutil.which, ('chromium', 'chromium-browser'))), None)


class Browser:
    """One tab that shows a page; close it by its own process."""

    def __init__(self, url, width=1000, height=600):
        self._profile = tempfile.TemporaryDirectory(prefix='browser', ignore_cleanup_errors=True)
        self._process = subprocess.Popen(
            [
                *(PROGRAM, '--headless', '--no-sandbox', '--no-first-run'),
                *('--use-angle=swiftshader', '--enable-unsafe-swiftshader'),
                *('--disable-dev-shm-usage', '--remote-debugging-port=0'),
                *(f'--window-size={width},{height}', f'--user-data-dir={self._profile.name}'),
                'about:blank',
            ],
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            preexec_fn=ends_with_parent(),
        )
        address = next(
            line.split()[-1] for line in self._process.stderr if 'DevTools listening' in line
        )
        port = address.split(':')[2].split('/')[0]
        with urllib.request.urlopen(f'http://127.0.0.1:{port}/json') as answer:
            (tab,) = [each for each in json.load(answer) if each['type'] == 'page']
        from websockets.sync.client import connect

        # Without pings: a browser that is busy for longer than their 20 s is waited for in `send`.
        self._socket = connect(tab['webSocketDebuggerUrl'], max_size=None, ping_interval=None)
        self._numbers = itertools.count()
        self._down = False
        self.send('Page.enable')
        self.send('Runtime.enable')
        self.send('Page.navigate', url=url)

    def close(self):
        """End the browser, with all of its processes."""
        self._socket.close()
        # All of its processes: one that is left would go on writing to the profile.
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._profile.cleanup()

    def send(self, method, **parameters):
        """Return the result of a command of the protocol."""
        number = next(self._numbers)
        self._socket.send(json.dumps({'id': number, 'method': method, 'params': parameters}))
        while True:
            answer = json.loads(self._socket.recv(timeout=PATIENCE))
            if answer.get('id') == number:
                assert 'error' not in answer, answer
                return answer['result']

    def ask(self, script):
        """Return the value of an expression in the page."""
        answer = self.send('Runtime.evaluate', expression=script, returnByValue=True)
        assert 'exceptionDetails' not in answer, answer
        return answer['result'].get('value')

    def text(self):
        """Return what the page says."""
        return self.ask("document.body ? document.body.innerText : ''")

    def wait_for(self, fact, what):
        """Return a fact once it is one; AssertionError, naming it, where it never is."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if found := fact():
                return found
            time.sleep(0.1)
        raise AssertionError(f'waited {PATIENCE:g} s for {what}; the page says: {self.text()}')

    def mouse(self, kind, x, y):
        """Send an event of the mouse."""
        # The button is down from its press on, and no longer with its release.
        self._down = kind == 'mousePressed' or (kind == 'mouseMoved' and self._down)
        button = {'button': 'none' if kind == 'mouseMoved' else 'left', 'clickCount': 1}
        self.send(
            'Input.dispatchMouseEvent', type=kind, x=x, y=y, buttons=int(self._down), **button
        )

    def click(self, x, y):
        """Click with the left button."""
        for kind in ('mouseMoved', 'mousePressed', 'mouseReleased'):
            self.mouse(kind, x, y)

    def box(self, script, *, covered=False):
        """Return the middle (x, y) of the element that an expression names, once it rests.

        A folder that opens moves what is below it for a while, and a click would miss; so it would
        where something else lies above, unless that is ``covered`` by what lets clicks through.
        """
        self.ask(f'({script}).scrollIntoView({{block: "center"}})')
        found = []

        def rests():
            found.append(
                self.ask(
                    f'(() => {{ const e = {script}, r = e.getBoundingClientRect();'
                    ' const x = r.x + r.width / 2, y = r.y + r.height / 2;'
                    ' const there = document.elementFromPoint(x, y);'
                    ' return [x, y, r.x, r.width, there !== null && e.contains(there)]; })()'
                )
            )
            time.sleep(RESTING)
            return found[-2:-1] == found[-1:] and (covered or found[-1][-1])

        self.wait_for(rests, 'an element that rests, and that nothing hides')
        return tuple(found[-1][:-1])

    def screenshot(self, path):
        """Write what is seen as PNG."""
        data = self.send('Page.captureScreenshot', format='png')['data']
        path.write_bytes(base64.b64decode(data))
