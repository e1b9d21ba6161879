#include "experiments/result_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <set>

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

struct flock whole_file(short type) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  return lock;
}

StoreWriter this_process(int workers) {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return {host.data(), ::getpid(), workers};
}

StoreWriter read_writer(const std::filesystem::path& lock_file) {
  StoreWriter writer;
  std::ifstream(lock_file) >> writer.host >> writer.process >> writer.workers;
  return writer;
}

/// For people and `status`; nothing depends on it, so that a full disk does no harm.
void write_writer(int descriptor, const StoreWriter& writer) {
  const std::string text = fmt::format("{} {} {}\n", writer.host, writer.process, writer.workers);
  if (::ftruncate(descriptor, 0) != 0) return;
  [[maybe_unused]] const ssize_t written = ::pwrite(descriptor, text.data(), text.size(), 0);
}

}  // namespace

std::string StoreWriter::text() const { return fmt::format("process {} on {}", process, host); }

const StoredTrial& RunResults::trial(const TrialKey& key) const {
  const auto found = trials.find(key);
  if (found != trials.end()) return found->second;
  throw InputError(
      fmt::format("no trial {} of cell {} here; it was not run yet", key.trial, key.cell));
}

RunResults read_results(const std::vector<std::filesystem::path>& stores,
                        const Experiment* extended) {
  if (stores.empty()) throw InputError("no result stores (trials*.sqlite) were found");
  RunResults results;
  std::set<TrialKey> conflicts;
  for (const std::filesystem::path& file : stores) {
    ResultStore store = ResultStore::open_to_read(file);
    const RunManifest manifest = store.manifest();
    if (&file == &stores.front()) results.manifest = manifest;
    // Of equivalent folders the first by name, so that the order of the stores does not matter.
    results.manifest.directory = std::min(results.manifest.directory, manifest.directory);
    std::string conflict = results.manifest.conflict_with(manifest);
    if (conflict.empty() && extended == nullptr && results.manifest.config != manifest.config) {
      conflict = "results of another configuration (number of trials, gates or paper counts)";
    }
    if (!conflict.empty()) {
      throw InputError(fmt::format("{}: holds {}, as in {}; only results of one run can be joined",
                                   file.string(), conflict, stores.front().string()));
    }
    results.manifest.add_origins(manifest);
    for (const auto& [key, trial] : store.trials()) {
      if (!insert_trial(results.trials, key, trial)) conflicts.insert(key);
    }
  }
  if (extended != nullptr) {
    results.manifest.config = extended->config_hash();
    results.manifest.yaml = extended->effective_yaml();
  }
  results.conflicts.assign(conflicts.begin(), conflicts.end());
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

std::optional<Shard> ResultFolder::shard_of(const std::filesystem::path& store) {
  long long index = 0;
  long long count = 0;
  int end = 0;
  const std::string name = store.filename().string();
  const int found = std::sscanf(name.c_str(), "trials-%lld-of-%lld.sqlite%n", &index, &count, &end);
  if (found != 2 || static_cast<std::size_t>(end) != name.size()) return std::nullopt;
  if (index < 0 || index >= count) return std::nullopt;
  return Shard{index, count};
}

RunResults ResultFolder::read(const Experiment* extended) const {
  const auto found = stores();
  if (found.empty()) {
    throw InputError(
        fmt::format("{}: no results here (trials*.sqlite), check the path", path_.string()));
  }
  return read_results(found, extended);
}

FileDescriptor ResultFolder::lock(const std::optional<Shard>& shard, int workers) const {
  make_folder(path_);
  const std::filesystem::path file = lock_of(store_of(shard));
  FileDescriptor descriptor(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (descriptor.get() < 0) {
    throw IoError(fmt::format("{}: cannot be written ({}); give another --out", file.string(),
                              std::strerror(errno)));
  }
  // A lock of the open file, not of the process: it can be asked for without being taken.
  struct flock lock = whole_file(F_WRLCK);
  if (::fcntl(descriptor.get(), F_OFD_SETLK, &lock) != 0) {
    if (errno != EAGAIN && errno != EACCES) {
      throw IoError(fmt::format("{}: cannot be locked ({}); give another --out", file.string(),
                                std::strerror(errno)));
    }
    throw InputError(
        fmt::format("{}: another run ({}) is writing here, wait for it or give another --out",
                    path_.string(), read_writer(file).text()));
  }
  write_writer(descriptor.get(), this_process(workers));
  return descriptor;
}

std::optional<StoreWriter> ResultFolder::writer_of(const std::filesystem::path& store) {
  const std::filesystem::path file = lock_of(store);
  const FileDescriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  struct flock lock = whole_file(F_RDLCK);
  if (descriptor.get() < 0 || ::fcntl(descriptor.get(), F_OFD_GETLK, &lock) != 0 ||
      lock.l_type == F_UNLCK) {
    return std::nullopt;
  }
  return read_writer(file);
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
