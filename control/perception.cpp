#include "control/perception.h"

#include <algorithm>

namespace binpick {

std::vector<Detection> merge_looks(std::vector<Detection> first,
                                   const std::vector<Detection>& second, double same_place) {
  const auto seen_first = first.size();
  for (const Detection& again : second) {
    const auto end = first.begin() + static_cast<std::ptrdiff_t>(seen_first);
    const auto same = std::find_if(first.begin(), end, [&](const Detection& known) {
      const Eigen::Vector3d moved =
          known.T_scene_model.translation() - again.T_scene_model.translation();
      return known.model == again.model && moved.norm() < same_place;
    });
    if (same == end) {
      first.push_back(again);
    } else if (again.confidence > same->confidence) {
      *same = again;
    }
  }
  return first;
}

}  // namespace binpick
