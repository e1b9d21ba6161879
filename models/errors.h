#pragma once

#include <stdexcept>
#include <string>

namespace binpick {

/// What was given (configuration, scene, mesh, URDF, cloud, option) cannot be used.
/// The message reads `file:line:col: what is wrong, and what to do`; several problems come as
/// several lines. The program exits with 2 and has written nothing.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file or folder cannot be read or written (missing rights, full disk). The program exits
/// with 3; results written earlier are intact.
class IoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace binpick
