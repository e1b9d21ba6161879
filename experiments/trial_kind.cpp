#include "experiments/trial_kind.h"

#include <utility>

namespace binpick {

TrialSeeds::TrialSeeds(Seed master, std::string_view experiment, std::string_view cell,
                       std::int64_t trial) {
  const Seed of_experiment = derive_seed(master, experiment);
  const auto index = static_cast<std::uint64_t>(trial);
  shared_ = derive_seed(derive_seed(of_experiment, "all cells"), index);
  own_ = derive_seed(derive_seed(derive_seed(of_experiment, "cell"), cell), index);
}

Seed TrialSeeds::shared(std::string_view purpose) const noexcept {
  return derive_seed(shared_, purpose);
}

Seed TrialSeeds::own(std::string_view purpose) const noexcept { return derive_seed(own_, purpose); }

void TrialKindRegistry::add(std::string name, Factory factory) {
  factories_[std::move(name)] = std::move(factory);
}

std::unique_ptr<TrialKind> TrialKindRegistry::make(const std::string& name) const {
  const auto found = factories_.find(name);
  return found == factories_.end() ? nullptr : found->second();
}

std::vector<std::string> TrialKindRegistry::names() const {
  std::vector<std::string> result;
  for (const auto& [name, factory] : factories_) result.push_back(name);
  return result;
}

}  // namespace binpick
