#include "experiments/trial_recorder.h"

#include <fmt/format.h>

#include "models/errors.h"
#include "sim/renderer.h"
#include "sim/video_writer.h"

namespace binpick {
namespace {

constexpr long kStepsPerTraceRow = 10;
constexpr int kFramesPerSecond = 25;
constexpr long kStepsPerFrame = 1000 / kFramesPerSecond;
constexpr int kFilmWidth = 960;
constexpr int kFilmHeight = 540;

std::ofstream open_for_writing(const std::filesystem::path& file) {
  std::ofstream stream(file);
  if (!stream) throw IoError(fmt::format("{}: cannot be written", file.string()));
  return stream;
}

}  // namespace

struct TrialRecorder::Film {
  Renderer renderer;
  VideoWriter writer;

  Film(const std::filesystem::path& file, const std::shared_ptr<const WorldTemplate>& shared)
      : renderer(shared, kFilmWidth, kFilmHeight),
        writer(file, kFilmWidth, kFilmHeight, kFramesPerSecond) {}
};

TrialRecorder::TrialRecorder(const TrialContext& context, World& world) : world_(world) {
  if (context.video) film_ = std::make_unique<Film>(*context.video, world.shared_template());
  if (!context.trace) return;
  std::error_code error;
  std::filesystem::create_directories(*context.trace, error);
  trace_ = open_for_writing(*context.trace / "trace.csv");
  events_ = open_for_writing(*context.trace / "events.csv");
  trace_ << "time_s,q1,q2,q3,q4,q5,q6,q7,tcp_x_m,tcp_y_m,tcp_z_m,jaw_width_m,jaw_force_n,"
            "contact_x_n,contact_y_n,contact_z_n\n";
  events_ << "time_s,state,next,object,detail\n";
}

TrialRecorder::~TrialRecorder() = default;

std::function<void(World&)> TrialRecorder::callback() {
  if (!trace_.is_open() && !film_) return {};
  return [this](World& world) { record(world); };
}

void TrialRecorder::record(World& world) {
  if (trace_.is_open() && steps_ % kStepsPerTraceRow == 0) write_trace_row(world);
  if (film_ && steps_ % kStepsPerFrame == 0) {
    film_->writer.add(film_->renderer.colour(world, View::kPicture, kFilmWidth, kFilmHeight));
  }
  ++steps_;
}

void TrialRecorder::write_trace_row(World& world) {
  const RobotState state = world.sensors();
  const Eigen::Vector3d p_tcp = world.T_world_tcp().translation();
  const Eigen::Vector3d force = world.contact_force_on_robot();
  trace_ << fmt::format("{:.3f}", world.time());
  for (const double q : state.joints.q) trace_ << fmt::format(",{:.5f}", q);
  trace_ << fmt::format(",{:.5f},{:.5f},{:.5f},{:.5f},{:.2f},{:.2f},{:.2f},{:.2f}\n", p_tcp.x(),
                        p_tcp.y(), p_tcp.z(), state.gripper.width, state.gripper.force, force.x(),
                        force.y(), force.z());
}

void TrialRecorder::note(const AutomatonEvent& event) {
  if (!events_.is_open()) return;
  events_ << fmt::format("{:.3f},{},{},{},\"{}\"\n", world_.time(), to_text(event.state),
                         to_text(event.next), event.object, event.detail);
}

}  // namespace binpick
