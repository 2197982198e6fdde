"""A real browser without a screen, driven through Chrome's remote protocol."""

import base64
import itertools
import json
import shutil
import subprocess
import tempfile
import time
import urllib.request

PATIENCE = 60.0  # [s] a software renderer on a busy machine
PROGRAM = next(filter(None, map(shutil.which, ('chromium', 'chromium-browser'))), None)


class Browser:
    """One tab that shows a page; close it by its own process."""

    def __init__(self, url, width=1000, height=600):
        self._profile = tempfile.TemporaryDirectory(prefix='browser')
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
        )
        address = next(
            line.split()[-1] for line in self._process.stderr if 'DevTools listening' in line
        )
        port = address.split(':')[2].split('/')[0]
        with urllib.request.urlopen(f'http://127.0.0.1:{port}/json') as answer:
            (tab,) = [each for each in json.load(answer) if each['type'] == 'page']
        from websockets.sync.client import connect

        self._socket = connect(tab['webSocketDebuggerUrl'], max_size=None)
        self._numbers = itertools.count()
        self.send('Page.enable')
        self.send('Runtime.enable')
        self.send('Page.navigate', url=url)

    def close(self):
        self._socket.close()
        self._process.kill()
        self._process.wait()
        self._profile.cleanup()

    def send(self, method, **parameters):
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
        return self.ask("document.body ? document.body.innerText : ''")

    def wait_for(self, fact, what):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if found := fact():
                return found
            time.sleep(0.1)
        raise AssertionError(f'waited {PATIENCE:g} s for {what}; the page says: {self.text()}')

    def mouse(self, kind, x, y):
        button = {'button': 'left', 'clickCount': 1, 'buttons': 1}
        self.send('Input.dispatchMouseEvent', type=kind, x=x, y=y, **button)

    def click(self, x, y):
        for kind in ('mouseMoved', 'mousePressed', 'mouseReleased'):
            self.mouse(kind, x, y)

    def box(self, script):
        """Return the middle (x, y) of the element that an expression names."""
        self.ask(f'({script}).scrollIntoView({{block: "center"}})')
        return tuple(
            self.ask(
                f'(() => {{ const r = ({script}).getBoundingClientRect();'
                ' return [r.x + r.width / 2, r.y + r.height / 2, r.x, r.width]; })()'
            )
        )

    def screenshot(self, path):
        data = self.send('Page.captureScreenshot', format='png')['data']
        path.write_bytes(base64.b64decode(data))
