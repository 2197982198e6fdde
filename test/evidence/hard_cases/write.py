"""Write the generated families into the catalogue.

PYTHONPATH=.:test python -m evidence.hard_cases.write [FAMILY ...]
"""

import sys
import time

from evidence.hard_cases.families import FAMILIES, generate

from drake_geom_ros.evidence.hard_cases.cases import CATALOGUE, text_of


def main():
    for name in sys.argv[1:] or FAMILIES:
        start = time.perf_counter()
        cases = generate(name)
        (CATALOGUE / f'{name}.json').write_text(text_of(cases))
        print(f'{name}: {len(cases)} cases, {time.perf_counter() - start:.1f} s', flush=True)


if __name__ == '__main__':
    main()
