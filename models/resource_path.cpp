#include "models/resource_path.h"

#include <fmt/format.h>

#include <algorithm>

#include "models/errors.h"

namespace binpick {

std::filesystem::path resolve_inside(const std::filesystem::path& directory,
                                     const std::string& name) {
  const std::filesystem::path relative(name);
  if (name.empty() || name.find("://") != std::string::npos || relative.is_absolute() ||
      std::find(relative.begin(), relative.end(), "..") != relative.end()) {
    throw InputError(fmt::format(
        "'{}' is not a file name relative to the description's own folder; name a file in it",
        name));
  }
  std::error_code error;
  const std::filesystem::path root =
      std::filesystem::canonical(directory.empty() ? "." : directory, error);
  const std::filesystem::path file = std::filesystem::canonical(directory / relative, error);
  if (error || !std::filesystem::is_regular_file(file, error)) {
    throw InputError(fmt::format("there is no file '{}' in {}", name, directory.string()));
  }
  const bool inside =
      std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first == root.end();
  if (!inside) throw InputError(fmt::format("'{}' links to a place outside its folder", name));
  return directory / relative;
}

}  // namespace binpick
