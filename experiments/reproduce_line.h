#pragma once

#include <string>

#include "experiments/result_store.h"

namespace binpick {

/// The shell command that runs this trial of the results in `folder` again.
[[nodiscard]] std::string reproduce_line(const std::string& folder, const TrialKey& key);

/// `text` as one word of a POSIX shell.
[[nodiscard]] std::string shell_word(const std::string& text);

}  // namespace binpick
