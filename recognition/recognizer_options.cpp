#include "recognition/recognizer_options.h"

#include <fmt/format.h>

#include <string>

#include "models/errors.h"

namespace binpick {

void RecognizerOptions::validate() const {
  std::string problems;
  const auto require = [&](bool good, std::string_view name, double value, std::string_view range) {
    if (good) return;
    problems += fmt::format("{}recognizer: {} is {}, must be in {}", problems.empty() ? "" : "\n",
                            name, value, range);
  };
  require(success_probability > 0.0 && success_probability < 1.0, "success_probability",
          success_probability, "(0, 1)");
  require(visibility > 0.0 && visibility < 1.0, "visibility", visibility, "(0, 1)");
  require(penalty > 0.0 && penalty < 1.0, "penalty", penalty, "(0, 1)");
  require(same_object_share > 0.0 && same_object_share <= 1.0, "same_object_share",
          same_object_share, "(0, 1]");
  require(jobs >= 1 && jobs <= 1024, "jobs", jobs, "1 .. 1024");
  if (!problems.empty()) throw InputError(problems);
}

}  // namespace binpick
