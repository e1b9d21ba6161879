#include "experiments/trial_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>

#include "experiments/trial_replay.h"
#include "experiments/write_file.h"
#include "models/errors.h"
#include "sim/png_writer.h"
#include "sim/renderer.h"
#include "sim/video_writer.h"

namespace binpick {
namespace {

constexpr long kStepsPerTraceRow = 10;
constexpr int kFramesPerSecond = 25;
constexpr long kStepsPerFrame = 1000 / kFramesPerSecond;
constexpr int kFilmWidth = 960;
constexpr int kFilmHeight = 540;
constexpr int kInsetWidth = 240;  // the depth camera's view, in the film's lower right corner
constexpr int kInsetHeight = 180;
constexpr int kInsetMargin = 12;
constexpr int kPictureWidth = 480;
constexpr int kPictureHeight = 270;

std::ofstream open_for_writing(const std::filesystem::path& file) {
  std::ofstream stream(file);
  if (!stream) throw IoError(fmt::format("{}: cannot be written", file.string()));
  return stream;
}

void inset(const ColourImage& small, ColourImage& large) {
  const int left = large.width - small.width - kInsetMargin;
  const int top = large.height - small.height - kInsetMargin;
  for (int v = 0; v < small.height; ++v) {
    std::copy_n(small.rgb.begin() + std::ptrdiff_t{3} * v * small.width,
                std::ptrdiff_t{3} * small.width,
                large.rgb.begin() + std::ptrdiff_t{3} * ((top + v) * large.width + left));
  }
}

}  // namespace

struct TrialRecorder::Film {
  Renderer renderer;
  VideoWriter writer;

  Film(const std::filesystem::path& file, const std::shared_ptr<const WorldTemplate>& shared)
      : renderer(shared, kFilmWidth, kFilmHeight),
        writer(file, kFilmWidth, kFilmHeight, kFramesPerSecond) {}

  void add(World& world) {
    ColourImage frame = renderer.colour(world, View::kPicture, kFilmWidth, kFilmHeight);
    RangeImage depth;
    depth.intrinsics.width = kInsetWidth;
    depth.intrinsics.height = kInsetHeight;
    depth.depth = renderer.depth(world, View::kDepthCamera, kInsetWidth, kInsetHeight).z;
    inset(false_colour(depth), frame);
    writer.add(frame);
  }
};

/// What is for people: pictures and the replay.
struct TrialRecorder::Album {
  std::filesystem::path folder;
  Renderer renderer;
  TrialReplay replay;
  int pictures = 0;

  Album(std::filesystem::path where, World& world)
      : folder(std::move(where)),
        renderer(world.shared_template(), kPictureWidth, kPictureHeight),
        replay(world) {}

  void take_picture(World& world, const std::string& what) {
    const std::string name = fmt::format("{:02d}_{}_{:.2f}s.png", pictures++, what, world.time());
    write_png(folder / name, renderer.colour(world, View::kPicture, kPictureWidth, kPictureHeight));
  }
};

TrialRecorder::TrialRecorder(const TrialContext& context, World& world) : world_(world) {
  if (context.video) film_ = std::make_unique<Film>(*context.video, world.shared_template());
  if (!context.trace) return;
  make_folder(*context.trace);
  trace_ = open_for_writing(*context.trace / "trace.csv");
  events_ = open_for_writing(*context.trace / "events.csv");
  trace_ << "time_s,q1,q2,q3,q4,q5,q6,q7,tcp_x_m,tcp_y_m,tcp_z_m,jaw_width_m,jaw_force_n,"
            "contact_x_n,contact_y_n,contact_z_n\n";
  events_ << "time_s,state,next,object,detail\n";
  album_ = std::make_unique<Album>(*context.trace, world);
}

TrialRecorder::~TrialRecorder() {
  if (!album_) return;
  try {
    album_->take_picture(world_, "end");
    album_->replay.write(world_, album_->folder / "replay.json");
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
  }
}

std::function<void(World&)> TrialRecorder::callback() {
  if (!album_ && !film_) return {};
  return [this](World& world) { record(world); };
}

void TrialRecorder::record(World& world) {
  if (album_) {
    if (steps_ == 0) album_->take_picture(world, "start");
    if (steps_ % kStepsPerTraceRow == 0) write_trace_row(world);
    album_->replay.step(world);
  }
  if (film_ && steps_ % kStepsPerFrame == 0) film_->add(world);
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
  if (!album_) return;
  events_ << fmt::format("{:.3f},{},{},{},\"{}\"\n", world_.time(), to_text(event.state),
                         to_text(event.next), event.object, event.detail);
  album_->replay.note(world_,
                      fmt::format("{} {} {}", to_text(event.state), event.object, event.detail));
  // IJRR 2012, Fig. 16: the moment of each grasp.
  if (event.state == AutomatonState::kGraspObject) {
    const bool held = event.next == AutomatonState::kCarryAway;
    album_->take_picture(world_, fmt::format("{}_{}", event.object, held ? "held" : "missed"));
  }
}

}  // namespace binpick
