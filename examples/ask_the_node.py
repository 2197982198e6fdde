"""Move a frame of a running node's scene and print its answers: topics and services only.

Start the node with scenes/minimal.yaml first, see the README.
"""

from drake_geom_ros.client import SceneGraphClient


def main():
    """Lower the ball on the floor in three steps."""
    with SceneGraphClient() as client:
        results = []
        client.listener.on_signed_distances(results.append)

        def results_at(height):
            """Pose the ball, and return the result for that pose once it has come."""
            client.publish_poses({'ball': [0.2, 0.0, height, 0.0, 0.0, 0.0, 1.0]}, stamp=height)
            return [found for found in results if found.stamp == height]

        for height in (0.3, 0.1, 0.05):  # the stamp tells this answer from others
            (found, *_) = client.wait_for(lambda h=height: results_at(h), 'a result')
            for pair in found:
                names = f'{pair.name_a} to {pair.name_b}'
                print(f'ball at {height} m: {names}: {pair.distance:.6f} m')

        reasons = client.explain_filter('world/floor', 'world/post')
        print('floor to post is left out:', ', '.join(reasons))


if __name__ == '__main__':
    main()
