#pragma once

#include <filesystem>
#include <vector>

namespace binpick {

/// One control period of a contact trial; z components, world axes.
struct ContactSample {
  double time = 0.0;              ///< s since the motion began
  double desired_height = 0.0;    ///< of the tool centre above the surface it will touch, m
  double height = 0.0;            ///< m; 0: touching
  double desired_velocity = 0.0;  ///< m/s
  double velocity = 0.0;          ///< m/s
  double spring_force = 0.0;      ///< what the virtual spring presses with: the desired force, N
  double true_force = 0.0;        ///< on the robot, N
  double estimated_force = 0.0;   ///< the observer's, N
  bool collision = false;         ///< hf1
};

/// What Figs. 5 and 6 plot, at 1 kHz.
using ContactSeries = std::vector<ContactSample>;

/// Writes CSV with a header line. @throws IoError
void write_contact_series(const std::filesystem::path& file, const ContactSeries& series);

/// The first peak of the true force: the highest value before it falls by a fifth; the highest of
/// all if it never does. 0 without contact.
[[nodiscard]] double first_force_peak(const ContactSeries& series);

}  // namespace binpick
