// The topics of sqmap_measure. Each takes the words behind its name, as main does: argv[0] is the name.
#pragma once

namespace sqmap::bench {

/// A topic returns this when its words are wrong: sqmap_measure prints the topic's usage then.
inline constexpr int k_wrong_usage = 64;

int measure_borders(int argc, char** argv);
int measure_clearance(int argc, char** argv);
int measure_cloth(int argc, char** argv);
int measure_coherence(int argc, char** argv);
int measure_contacts(int argc, char** argv);
int measure_distance(int argc, char** argv);
int measure_drape(int argc, char** argv);
int measure_dressed(int argc, char** argv);
int measure_first_touch(int argc, char** argv);
int measure_haptic(int argc, char** argv);
int measure_invariance(int argc, char** argv);
int measure_joints(int argc, char** argv);
int measure_pile(int argc, char** argv);
int measure_poses(int argc, char** argv);
int measure_rebake(int argc, char** argv);
int measure_scene_cost(int argc, char** argv);
int measure_segmentation(int argc, char** argv);
int measure_skin(int argc, char** argv);
int measure_wrap(int argc, char** argv);

}  // namespace sqmap::bench
