#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/world_template.h"

namespace binpick {

/// A world as MuJoCo's compiler takes it: an MJCF text and the mesh files that it names.
struct WorldSource {
  std::string mjcf;
  std::map<std::string, std::vector<char>> meshes;
};

/// Writes the world of `parts`.
///
/// Bodies: `link1`..`link7` (joints `joint1`..), `gripper`, `jaw_left`, `jaw_right`, `object<i>`
/// with a free joint, `frame` (mocap) for a pile. Geoms: `pad_left`, `pad_right`, hulls
/// `object<i>_hull<k>`, plane contact points `object<i>_point<k>`. Groups: 2 what is seen, 3 what
/// only collides, 4 what is seen in pictures alone.
///
/// Only explicit pairs touch: MuJoCo would combine the frictions of two geoms by their maximum, and
/// its own search for pairs costs more than the contacts. Pairs of objects carry 0.3 until a World
/// enters its trial's frictions; the bare robot (metal and varnish) keeps it.
[[nodiscard]] WorldSource write_world(const WorldParts& parts);

}  // namespace binpick
