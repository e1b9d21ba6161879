#include "sim/world_template.h"

#include <fmt/format.h>

#include <cstring>
#include <map>
#include <stdexcept>

#include "models/errors.h"
#include "sim/mjcf_writer.h"

namespace binpick {
namespace {

struct VfsDeleter {
  void operator()(mjVFS* vfs) const noexcept {
    mj_deleteVFS(vfs);
    delete vfs;
  }
};

constexpr const char* kWorldFile = "world.xml";

template <class Bytes>
void add_file(mjVFS& vfs, const std::string& name, const Bytes& bytes) {
  const int size = static_cast<int>(bytes.size());
  if (mj_makeEmptyFileVFS(&vfs, name.c_str(), size) != 0) {
    throw std::runtime_error("cannot hand '" + name + "' to MuJoCo");
  }
  std::memcpy(vfs.filedata[mj_findFileVFS(&vfs, name.c_str())], bytes.data(), bytes.size());
}

MjModelPtr compile(const WorldSource& source, const std::string& scene) {
  install_mujoco_handlers();
  const std::unique_ptr<mjVFS, VfsDeleter> vfs(std::make_unique<mjVFS>().release());
  mj_defaultVFS(vfs.get());
  add_file(*vfs, kWorldFile, source.mjcf);
  for (const auto& [name, bytes] : source.meshes) add_file(*vfs, name, bytes);
  std::array<char, 1000> error{};
  MjModelPtr model(mj_loadXML(kWorldFile, vfs.get(), error.data(), static_cast<int>(error.size())));
  if (!model) {
    throw InputError(fmt::format("{}: the physics refuses this cell: {}", scene, error.data()));
  }
  return model;
}

int find(const mjModel& model, int type, const std::string& name) {
  const int id = mj_name2id(&model, type, name.c_str());
  if (id < 0) throw std::logic_error("the world has no '" + name + "'");
  return id;
}

void find_robot(const mjModel& model, WorldIndex& index) {
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    const int joint = find(model, mjOBJ_JOINT, fmt::format("joint{}", i + 1));
    index.arm_qpos[i] = model.jnt_qposadr[joint];
    index.arm_dof[i] = model.jnt_dofadr[joint];
    index.arm_actuator[i] = find(model, mjOBJ_ACTUATOR, fmt::format("motor{}", i + 1));
  }
  const std::array<std::string, 2> sides{"left", "right"};
  for (std::size_t side = 0; side < 2; ++side) {
    const int joint = find(model, mjOBJ_JOINT, "jaw_" + sides[side]);
    index.jaw_qpos[side] = model.jnt_qposadr[joint];
    index.jaw_dof[side] = model.jnt_dofadr[joint];
    index.pad_geom[side] = find(model, mjOBJ_GEOM, "pad_" + sides[side]);
    index.finger_geoms[side] = {index.pad_geom[side],
                                find(model, mjOBJ_GEOM, "finger_" + sides[side])};
  }
  index.jaw_actuator = find(model, mjOBJ_ACTUATOR, "drive");
  index.tcp_site = find(model, mjOBJ_SITE, "tcp");
}

WorldIndex make_index(const mjModel& model, const WorldParts& parts) {
  WorldIndex index;
  find_robot(model, index);
  if (const int frame = mj_name2id(&model, mjOBJ_BODY, "frame"); frame >= 0) {
    index.frame_mocap = model.body_mocapid[frame];
  }
  index.geom_object.assign(static_cast<std::size_t>(model.ngeom), -1);
  for (std::size_t i = 0; i < parts.objects.size(); ++i) {
    const int body = find(model, mjOBJ_BODY, fmt::format("object{}", i));
    const int joint = model.body_jntadr[body];
    index.object_body.push_back(body);
    index.object_qpos.push_back(model.jnt_qposadr[joint]);
    index.object_dof.push_back(model.jnt_dofadr[joint]);
  }
  const int first_robot_body = find(model, mjOBJ_BODY, "base");
  const int last_robot_body = find(model, mjOBJ_BODY, "jaw_right");
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    if (first_robot_body <= body && body <= last_robot_body) {
      index.geom_object[std::size_t(geom)] = WorldIndex::kRobot;
    }
    for (std::size_t i = 0; i < index.object_body.size(); ++i) {
      if (index.object_body[i] == body) index.geom_object[std::size_t(geom)] = static_cast<int>(i);
    }
  }
  return index;
}

}  // namespace

std::shared_ptr<const WorldTemplate> make_world_template(WorldParts parts) {
  auto made = std::make_shared<WorldTemplate>();
  made->model = compile(write_world(parts), parts.scene.name);
  made->index = make_index(*made->model, parts);
  made->parts = std::move(parts);
  return made;
}

std::shared_ptr<const WorldTemplate> make_world_template(const Scene& scene) {
  WorldParts parts;
  parts.scene = scene;
  parts.arm = load_lwr();
  parts.gripper = load_gripper();
  std::map<std::string, ObjectModel> known;
  for (const std::string& name : scene.object_names()) {
    if (!known.contains(name)) known.emplace(name, load_known_object(name));
    parts.objects.push_back(known.at(name));
  }
  return make_world_template(std::move(parts));
}

}  // namespace binpick
