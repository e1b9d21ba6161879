#include "experiments/result_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <sstream>

#include "experiments/write_file.h"
#include "models/errors.h"

namespace binpick {
namespace {

bool is_store(const std::filesystem::path& file) {
  return file.extension() == ".sqlite" && file.filename().string().starts_with("trials");
}

std::filesystem::path lock_of(const std::filesystem::path& store) {
  return std::filesystem::path(store).replace_extension(".lock");
}

}  // namespace

RunResults read_results(const std::vector<std::filesystem::path>& stores) {
  if (stores.empty()) throw InputError("no result stores (trials*.sqlite) were found");
  RunResults results;
  std::set<std::string> cpus;
  std::set<TrialKey> conflicts;
  for (const std::filesystem::path& file : stores) {
    ResultStore store = ResultStore::open_to_read(file);
    const RunManifest manifest = store.manifest();
    if (cpus.empty()) results.manifest = manifest;
    // Of equivalent folders the first by name, so that the order of the stores does not matter.
    results.manifest.directory = std::min(results.manifest.directory, manifest.directory);
    std::istringstream classes(manifest.cpu);
    for (std::string each; std::getline(classes, each, '|');) cpus.insert(each);
    std::string conflict = results.manifest.conflict_with(manifest);
    if (conflict.empty() && results.manifest.config != manifest.config) {
      conflict = "results of another configuration (number of trials, gates or paper counts)";
    }
    if (!conflict.empty()) {
      throw InputError(fmt::format("{}: holds {}, as in {}; only results of one run can be joined",
                                   file.string(), conflict, stores.front().string()));
    }
    for (const auto& [key, trial] : store.trials()) {
      if (!insert_trial(results.trials, key, trial)) conflicts.insert(key);
    }
  }
  results.conflicts.assign(conflicts.begin(), conflicts.end());
  results.manifest.cpu = fmt::format("{}", fmt::join(cpus, "|"));
  return results;
}

std::filesystem::path ResultFolder::default_path(const Experiment& experiment) {
  return std::filesystem::path("results") /
         fmt::format("{}-{}", experiment.config().name, experiment.config_hash().substr(0, 12));
}

std::vector<std::filesystem::path> ResultFolder::stores() const {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(path_, error)) {
    if (is_store(entry.path())) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::filesystem::path ResultFolder::store_of(const std::optional<Shard>& shard) const {
  return path_ / (shard ? fmt::format("trials-{}-of-{}.sqlite", shard->index, shard->count)
                        : "trials.sqlite");
}

RunResults ResultFolder::read() const {
  const auto found = stores();
  if (found.empty()) {
    throw InputError(
        fmt::format("{}: no results here (trials*.sqlite), check the path", path_.string()));
  }
  return read_results(found);
}

FileDescriptor ResultFolder::lock(const std::optional<Shard>& shard) const {
  make_folder(path_);
  const std::filesystem::path file = lock_of(store_of(shard));
  FileDescriptor descriptor(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (descriptor.get() < 0) {
    throw IoError(fmt::format("{}: cannot be written ({}); give another --out", file.string(),
                              std::strerror(errno)));
  }
  if (::flock(descriptor.get(), LOCK_EX | LOCK_NB) != 0) {
    throw InputError(
        fmt::format("{}: another run is writing here, wait for it or give another "
                    "--out",
                    path_.string()));
  }
  return descriptor;
}

bool ResultFolder::busy() const {
  const auto found = stores();
  return std::any_of(found.begin(), found.end(), [](const std::filesystem::path& store) {
    const FileDescriptor descriptor(::open(lock_of(store).c_str(), O_RDONLY | O_CLOEXEC));
    return descriptor.get() >= 0 && ::flock(descriptor.get(), LOCK_SH | LOCK_NB) != 0;
  });
}

void ResultFolder::clear(const std::optional<Shard>& shard) const {
  std::vector<std::filesystem::path> files = shard ? std::vector{store_of(shard)} : stores();
  for (const std::filesystem::path& store : std::vector(files)) {
    files.push_back(store.string() + "-journal");
  }
  for (const char* name : {"trials.csv", "trials.json", "report.html"}) {
    files.push_back(path_ / name);
  }
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    std::filesystem::remove(file, error);
    if (error) {
      throw IoError(fmt::format("{}: cannot be removed ({})", file.string(), error.message()));
    }
  }
}

}  // namespace binpick
