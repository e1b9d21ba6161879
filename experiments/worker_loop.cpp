#include "experiments/worker_loop.h"

#include <unistd.h>

#include <cstdio>
#include <exception>
#include <optional>

#include "experiments/experiment.h"
#include "experiments/line_pipe.h"
#include "experiments/run_trial.h"
#include "experiments/worker_protocol.h"
#include "models/errors.h"

namespace binpick {
namespace {

bool reply(const WorkerReply& message) { return write_line(kWorkerReplies, encode(message)); }

std::optional<WorkerOrder> next_order(LineReader& orders) {
  std::optional<std::string> line = orders.next();
  while (!line && orders.fill()) line = orders.next();
  return line ? decode_order(*line) : std::nullopt;
}

class Worker {
 public:
  Worker(const WorkerOrder& setup, const TrialKindRegistry& registry)
      : experiment_(Experiment::from_text(setup.yaml, "effective configuration", setup.directory,
                                          registry)),
        kind_(experiment_.make_kind()) {
    prepare(setup.cell);
  }

  /// @return false when this process must not run another trial.
  bool run(const WorkerOrder& order) {
    // Failing to enter the folder costs nothing but tidiness.
    [[maybe_unused]] const int entered = ::chdir(order.folder.c_str());
    if (order.cell != prepared_cell_) prepare(order.cell);
    const Cell& cell = experiment_.cells()[order.cell];
    TrialContext context{experiment_.seeds(cell, order.trial), order.trial, {}, {}, {}};
    context.report_stage = [](TrialStage stage) {
      reply({.type = WorkerReply::Type::kStage, .stage = stage});
    };
    TrialRun run = run_trial(*kind_, context);
    const bool sent = reply({.type = WorkerReply::Type::kRecord,
                             .record = std::move(run.record),
                             .ends = !run.kind_usable});
    return sent && run.kind_usable;
  }

 private:
  void prepare(std::size_t cell) {
    experiment_.assign(experiment_.cells()[cell], *kind_);
    kind_->prepare(experiment_.directory());
    prepared_cell_ = cell;
  }

  Experiment experiment_;
  std::unique_ptr<TrialKind> kind_;
  std::size_t prepared_cell_ = 0;
};

}  // namespace

int run_worker_loop(const TrialKindRegistry& registry) {
  // Line by line, so that what a trial prints arrives before its record.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  LineReader orders{FileDescriptor(kWorkerOrders)};
  const auto setup = next_order(orders);
  if (!setup || setup->type != WorkerOrder::Type::kSetup) return 2;
  try {
    Worker worker(*setup, registry);
    reply({.type = WorkerReply::Type::kReady});
    for (auto order = next_order(orders); order; order = next_order(orders)) {
      if (!worker.run(*order)) break;
    }
    return 0;
  } catch (const InputError& error) {
    reply({.type = WorkerReply::Type::kInputError, .message = error.what()});
  } catch (const std::exception& error) {
    reply({.type = WorkerReply::Type::kFailed, .message = error.what()});
  }
  return 1;
}

}  // namespace binpick
