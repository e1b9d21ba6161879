#include "experiments/run_manifest.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/content_hash.h"

namespace binpick {
namespace {

/// The stored keys and the fields that they name, in one place for both directions.
template <class Manifest>
auto fields_of(Manifest& manifest) {
  return std::array{std::pair{"experiment", &manifest.experiment},
                    std::pair{"identity", &manifest.identity},
                    std::pair{"inputs", &manifest.inputs},
                    std::pair{"protocol", &manifest.protocol},
                    std::pair{"program", &manifest.program},
                    std::pair{"build", &manifest.build},
                    std::pair{"config", &manifest.config},
                    std::pair{"yaml", &manifest.yaml},
                    std::pair{"directory", &manifest.directory},
                    std::pair{"cpu", &manifest.cpu},
                    std::pair{"host", &manifest.host}};
}

/// The parts of both lists, sorted, each once.
std::string united(const std::string& a, const std::string& b) {
  std::set<std::string> parts;
  for (const std::string* list : {&a, &b}) {
    std::istringstream text(*list);
    for (std::string part; std::getline(text, part, '|');) parts.insert(part);
  }
  return fmt::format("{}", fmt::join(parts, "|"));
}

/// The lines of an effective configuration that decide the records; see Experiment::identity_hash.
std::vector<std::string> deciding_lines(const std::string& yaml) {
  std::vector<std::string> lines;
  std::istringstream text(yaml);
  for (std::string line; std::getline(text, line);) {
    const std::string key = line.substr(0, line.find(':'));
    if (key == "paper" || key == "gates") break;  // the last ones
    if (key == "title" || key == "trials" || key == "time_limit_s" || key == "stopping" ||
        key == "format") {
      continue;
    }
    lines.push_back(line.substr(line.find_first_not_of(" -")));
  }
  return lines;
}

/// What `theirs` has in another way than `ours`, for a person: the first line that differs.
std::string first_difference(const std::string& ours, const std::string& theirs) {
  const std::vector<std::string> a = deciding_lines(ours);
  const std::vector<std::string> b = deciding_lines(theirs);
  const auto [in_a, in_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  const auto quoted = [](const auto& line, const auto& end) {
    return line == end ? std::string("nothing") : fmt::format("'{}'", *line);
  };
  return fmt::format("{} instead of {}", quoted(in_b, b.end()), quoted(in_a, a.end()));
}

}  // namespace

RunManifest RunManifest::of(const Experiment& experiment) {
  RunManifest manifest;
  manifest.experiment = experiment.config().name;
  manifest.identity = experiment.identity_hash();
  manifest.inputs = experiment.inputs_hash();
  manifest.protocol = fmt::format("{}", experiment.protocol_version());
  manifest.program = program_version();
  manifest.build = program_build();
  manifest.config = experiment.config_hash();
  manifest.yaml = experiment.effective_yaml();
  manifest.directory = experiment.directory().string();
  manifest.cpu = cpu_class();
  manifest.host = host_name();
  return manifest;
}

RunManifest RunManifest::from_entries(const std::map<std::string, std::string>& entries) {
  RunManifest manifest;
  for (const auto& [key, field] : fields_of(manifest)) {
    const auto entry = entries.find(key);
    if (entry != entries.end()) *field = entry->second;
  }
  return manifest;
}

std::map<std::string, std::string> RunManifest::entries() const {
  std::map<std::string, std::string> entries;
  for (const auto& [key, field] : fields_of(*this)) entries[key] = *field;
  return entries;
}

void RunManifest::add_origins(const RunManifest& other) {
  cpu = united(cpu, other.cpu);
  host = united(host, other.host);
}

std::string RunManifest::conflict_with(const RunManifest& other) const {
  if (experiment != other.experiment) {
    return fmt::format("results of experiment '{}', not of '{}'", other.experiment, experiment);
  }
  if (identity != other.identity) {
    return fmt::format("results of another configuration ({})", first_difference(yaml, other.yaml));
  }
  if (inputs != other.inputs) return "results of other scene or model files";
  if (protocol != other.protocol) {
    return fmt::format("results of protocol version {}, not {}", other.protocol, protocol);
  }
  if (program != other.program) {
    return fmt::format("results of binpick {}, not {}", other.program, program);
  }
  if (build != other.build) return "results of another build of binpick";
  return "";
}

std::string program_version() { return BINPICK_VERSION; }

std::string program_build() {
  ContentHash hash;
  hash.add_file("/proc/self/exe");
  return hash.hex();
}

std::string cpu_class() {
  std::ifstream file("/proc/cpuinfo");
  std::set<std::string> flags;
  for (std::string line; flags.empty() && std::getline(file, line);) {
    if (!line.starts_with("flags") && !line.starts_with("Features")) continue;
    std::istringstream words(line.substr(line.find(':') + 1));
    for (std::string word; words >> word;) flags.insert(word);
  }
  std::string result = "cpu";
  for (const char* flag : {"sse4_2", "avx", "avx2", "fma", "avx512f", "asimd"}) {
    if (flags.contains(flag)) result += fmt::format(" {}", flag);
  }
  return result;
}

std::string host_name() {
  utsname host{};
  if (::uname(&host) != 0) return "unknown";
  return fmt::format("{} ({} {})", host.nodename, host.sysname, host.release);
}

}  // namespace binpick
