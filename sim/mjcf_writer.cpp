#include "sim/mjcf_writer.h"

#include <fmt/format.h>

#include <cmath>

#include "models/mesh_import.h"
#include "sim/mesh_asset.h"

namespace binpick {
namespace {

// Hulls touch planes through points of their surface: MuJoCo finds at most three contacts of a mesh
// on a plane, next to each other, on which a flat base rocks. Spheres this small are points.
constexpr double kPointRadius = 1e-5;    // m
constexpr double kPointSpacing = 0.006;  // m
// Objects with more points than this are round and roll; the others tip over their edges.
constexpr std::size_t kMostCorners = 24;

// Reflected inertia of motor and spindle per jaw: a rotor of 1e-6 kg m^2 behind a spindle of 9 mm
// pitch, as small servo grippers have them.
constexpr double kJawArmature = 0.5;  // kg
constexpr double kJawDamping = 5.0;   // N s/m

// Base, shoulder and upper arm cannot reach anything in the cell.
constexpr std::size_t kFirstTouchingLink = 2;

constexpr double kPadThickness = 0.004;    // m
constexpr double kRollingFriction = 1e-3;  // m
constexpr double kSpinFriction = 5e-3;     // m, of a contact patch of about 1 cm

std::string text(const Eigen::Vector3d& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); }

std::string text(const Eigen::Vector4f& v) {
  return fmt::format("{} {} {} {}", v[0], v[1], v[2], v[3]);
}

std::string pose(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  return fmt::format("pos=\"{}\" quat=\"{} {} {} {}\"", text(Eigen::Vector3d(T.translation())),
                     q.w(), q.x(), q.y(), q.z());
}

std::string inertial(const BodyInertia& body) {
  const Eigen::Matrix3d& i = body.inertia;
  return fmt::format("<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>\n",
                     text(body.com), body.mass, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2),
                     i(1, 2));
}

class WorldWriter {
 public:
  explicit WorldWriter(const WorldParts& parts) : parts_(parts) {}

  WorldSource write() {
    write_cell();
    write_arm();
    for (std::size_t i = 0; i < parts_.objects.size(); ++i) write_object(i);
    write_pairs();
    source_.mjcf = fmt::format(
        "<mujoco model=\"binpick\">\n"
        "<compiler angle=\"radian\" inertiafromgeom=\"false\" autolimits=\"true\"/>\n"
        "{}<asset>\n{}</asset>\n<worldbody>\n{}</worldbody>\n<contact>\n{}</contact>\n{}</"
        "mujoco>\n",
        options(), assets_, bodies_, pairs_, actuators());
    return std::move(source_);
  }

 private:
  // Elliptic cones with impratio 10 and noslip keep a held kilogram from creeping: 0.01 mm in 10 s.
  // Constraints of several objects hardly couple: sparse Jacobians make a step of a settled pile of
  // seven 1.5 times as fast (step_settled_pile_of_seven), but that of a single object 1.4 times as
  // slow.
  [[nodiscard]] std::string options() const {
    const std::size_t objects = parts_.objects.size();
    const std::string_view jacobian = objects > 2 ? "sparse" : "dense";
    return fmt::format(
        "<option timestep=\"0.001\" solver=\"Newton\" jacobian=\"{}\" cone=\"elliptic\" "
        "impratio=\"10\" "
        "noslip_iterations=\"5\" collision=\"predefined\"><flag multiccd=\"enable\"/></option>\n"
        "<size nconmax=\"{}\" njmax=\"{}\"/>\n"
        "<statistic extent=\"1\" center=\"0.4 0 0.2\"/>\n"
        "<visual><map znear=\"0.02\" zfar=\"20\" shadowclip=\"1.4\" shadowscale=\"0.9\"/>"
        "<global offwidth=\"1920\" offheight=\"1080\"/>"
        "<quality shadowsize=\"4096\" offsamples=\"0\"/>"
        "<headlight ambient=\"0.36 0.36 0.38\" diffuse=\"0.22 0.22 0.22\" specular=\"0 0 0\"/>"
        "</visual>\n",
        jacobian, 80 + 60 * objects, 300 + 160 * objects);
  }

  // The mesh is stored under `name`; returns `name`.
  std::string add_mesh(const std::string& name, const TriangleMesh& mesh, bool shaded) {
    const std::string file = name + ".msh";
    if (source_.meshes.emplace(file, to_msh(mesh, shaded)).second) {
      assets_ += fmt::format("<mesh name=\"{}\" file=\"{}\"/>\n", name, file);
    }
    return name;
  }

  void add_mesh_geom(const std::string& name, const std::string& mesh, int group,
                     const std::string& rgba, std::string_view place = "") {
    bodies_ +=
        fmt::format("<geom name=\"{}\" type=\"mesh\" mesh=\"{}\" group=\"{}\" rgba=\"{}\" {}/>\n",
                    name, mesh, group, rgba, place);
  }

  void write_cell() {
    const Table& table = parts_.scene.table;
    assets_ +=
        "<texture name=\"sky\" type=\"skybox\" builtin=\"gradient\" rgb1=\"0.86 0.89 0.93\" "
        "rgb2=\"0.55 0.60 0.68\" width=\"256\" height=\"256\"/>\n"
        "<texture name=\"floor\" type=\"2d\" builtin=\"checker\" rgb1=\"0.48 0.50 0.52\" "
        "rgb2=\"0.44 0.46 0.48\" width=\"256\" height=\"256\"/>\n"
        "<material name=\"floor\" texture=\"floor\" texrepeat=\"8 8\" specular=\"0\"/>\n"
        "<texture name=\"wood\" type=\"2d\" builtin=\"flat\" rgb1=\"0.73 0.60 0.44\" "
        "mark=\"random\" markrgb=\"0.69 0.56 0.40\" random=\"0.4\" width=\"256\" height=\"64\"/>\n"
        "<material name=\"wood\" texture=\"wood\" texrepeat=\"3 12\" specular=\"0.1\" "
        "shininess=\"0.2\"/>\n"
        "<material name=\"red\" rgba=\"0.72 0.10 0.09 1\" specular=\"0.3\" shininess=\"0.4\"/>\n"
        "<material name=\"steel\" rgba=\"0.55 0.57 0.60 1\" specular=\"0.4\" shininess=\"0.5\"/>\n"
        "<material name=\"marking\" rgba=\"0.93 0.90 0.82 1\" specular=\"0\"/>\n"
        "<material name=\"frame\" rgba=\"0.85 0.87 0.90 0.25\"/>\n";
    bodies_ += fmt::format(
        "<light directional=\"true\" pos=\"0.9 -0.9 2.2\" dir=\"-0.25 0.35 -1\" "
        "diffuse=\"0.5 0.5 0.48\" specular=\"0.25 0.25 0.25\" castshadow=\"true\"/>\n"
        "<geom name=\"table\" type=\"plane\" size=\"5 5 1\" group=\"3\" rgba=\"1 1 1 1\"/>\n"
        "<geom name=\"table_top\" type=\"box\" size=\"{} {} 0.02\" pos=\"{} {} -0.02\" group=\"2\" "
        "material=\"wood\"/>\n"
        "<geom name=\"floor\" type=\"plane\" size=\"4 4 1\" pos=\"0 0 {}\" group=\"4\" "
        "material=\"floor\"/>\n",
        0.5 * table.size.x(), 0.5 * table.size.y(), table.centre.x(), table.centre.y(),
        -table.height);
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        const Eigen::Vector2d foot =
            table.centre +
            Eigen::Vector2d(x, y).cwiseProduct(0.5 * table.size - Eigen::Vector2d(0.06, 0.06));
        add_visual_box({foot.x(), foot.y(), -0.5 * table.height - 0.02},
                       {0.06, 0.06, table.height - 0.04}, "steel");
      }
    }
    for (const Container& container : parts_.scene.containers) write_container(container);
    if (parts_.scene.arrangement == "pile") write_frame();
    write_cameras();
  }

  void add_visual_box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size,
                      const char* material) {
    bodies_ +=
        fmt::format("<geom type=\"box\" pos=\"{}\" size=\"{}\" group=\"4\" material=\"{}\"/>\n",
                    text(centre), text(Eigen::Vector3d(0.5 * size)), material);
  }

  // Four thick boxes around an area; their names join walls_.
  void add_walls(const std::string& name, const Eigen::Vector2d& centre,
                 const Eigen::Vector2d& size, double height, double thickness,
                 const char* material) {
    for (int side = 0; side < 4; ++side) {
      const int across = side / 2;
      Eigen::Vector2d middle = centre;
      middle[across] += (side % 2 == 0 ? 0.5 : -0.5) * (size[across] + thickness);
      Eigen::Vector2d half = 0.5 * size;
      half[across] = 0.5 * thickness;
      half[1 - across] += across == 0 ? thickness : 0.0;
      walls_.push_back(fmt::format("{}_wall{}", name, side));
      bodies_ += fmt::format(
          "<geom name=\"{}\" type=\"box\" pos=\"{} {} {}\" size=\"{} {} {}\" group=\"2\" "
          "material=\"{}\"/>\n",
          walls_.back(), middle.x(), middle.y(), 0.5 * height, half.x(), half.y(), 0.5 * height,
          material);
    }
  }

  void write_container(const Container& container) {
    const std::string name = fmt::format("container{}", walls_.size());
    // The table top carries what lies inside; the sheet and the marking are drawn only.
    bodies_ += fmt::format(
        "<geom type=\"box\" pos=\"{} {} 0\" size=\"{} {} 0.001\" group=\"2\" "
        "material=\"{}\"/>\n",
        container.centre.x(), container.centre.y(), 0.5 * container.size.x(),
        0.5 * container.size.y(), container.has_walls() ? "red" : "marking");
    if (container.has_walls()) {
      add_walls(name, container.centre, container.size, container.wall_height,
                container.wall_thickness, "red");
    }
  }

  void write_frame() {
    const PileRecipe& pile = parts_.scene.pile;
    bodies_ += fmt::format("<body name=\"frame\" mocap=\"true\" pos=\"{} {} 0\">\n",
                           pile.centre.x(), pile.centre.y());
    add_walls("frame", Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(pile.frame_size),
              pile.frame_height, pile.frame_thickness, "frame");
    bodies_ += "</body>\n";
  }

  // MuJoCo's cameras look along -z with y up.
  void add_camera(const std::string& name, const Eigen::Vector3d& position,
                  const Eigen::Vector3d& look_at, double fovy) {
    SceneCamera camera;
    camera.position = position;
    camera.look_at = look_at;
    const Eigen::Matrix3d R = camera.T_world_camera().linear();
    bodies_ += fmt::format("<camera name=\"{}\" pos=\"{}\" xyaxes=\"{} {}\" fovy=\"{}\"/>\n", name,
                           text(position), text(Eigen::Vector3d(R.col(0))),
                           text(Eigen::Vector3d(-R.col(1))), fovy);
  }

  void write_cameras() {
    const Scene& scene = parts_.scene;
    const SceneCamera& camera = scene.camera;
    const double fovy = 2.0 * std::atan(0.5 * camera.height / camera.focal_length) * 180.0 / M_PI;
    add_camera("depth_camera", camera.position, camera.look_at, fovy);
    add_camera("picture", scene.picture_position, scene.picture_look_at, 38.0);
    // The sensor's housing behind the pinhole, and its post.
    const Eigen::Isometry3d T = camera.T_world_camera();
    Eigen::Isometry3d T_housing = T;
    T_housing.translation() = T * Eigen::Vector3d(0.0, 0.0, -0.035);
    bodies_ += fmt::format(
        "<geom type=\"box\" {} size=\"0.14 0.02 0.03\" group=\"4\" "
        "rgba=\"0.12 0.12 0.13 1\"/>\n",
        pose(T_housing));
    const Eigen::Vector3d head = T * Eigen::Vector3d(0.0, 0.0, -0.065);
    bodies_ += fmt::format(
        "<geom type=\"capsule\" fromto=\"{} {} {} {} {} {}\" size=\"0.012\" group=\"4\" "
        "material=\"steel\"/>\n",
        head.x(), head.y(), head.z(), head.x(), head.y(), -parts_.scene.table.height);
  }

  void write_arm() {
    import_arm_meshes();
    bodies_ += "<body name=\"base\">\n" + inertial(parts_.arm.base.inertia);
    write_link_shapes(parts_.arm.base, "base", false);
    for (std::size_t i = 0; i < parts_.arm.links.size(); ++i) {
      const JointDescription& joint = parts_.arm.joints[i];
      bodies_ += fmt::format(
          "<body name=\"link{0}\" {1}>\n"
          "<joint name=\"joint{0}\" type=\"hinge\" axis=\"{2}\" range=\"{3} {4}\"/>\n",
          i + 1, pose(joint.T_parent_joint), text(joint.axis), joint.lower, joint.upper);
      bodies_ += inertial(parts_.arm.links[i].inertia);
      write_link_shapes(parts_.arm.links[i], fmt::format("link{}", i + 1), i >= kFirstTouchingLink);
    }
    write_gripper();
    for (std::size_t i = 0; i <= parts_.arm.links.size(); ++i) bodies_ += "</body>\n";
  }

  // All of the arm's mesh files in one go, each once.
  void import_arm_meshes() {
    std::vector<std::filesystem::path> files;
    const auto collect = [&](const LinkDescription& link) {
      for (const auto* shapes : {&link.visuals, &link.collisions}) {
        for (const LinkShape& shape : *shapes) {
          const auto* mesh = std::get_if<LinkShape::Mesh>(&shape.geometry);
          if (mesh != nullptr && arm_meshes_.emplace(mesh->file, TriangleMesh{}).second) {
            files.push_back(mesh->file);
          }
        }
      }
    };
    collect(parts_.arm.base);
    for (const LinkDescription& link : parts_.arm.links) collect(link);
    if (files.empty()) return;
    std::vector<TriangleMesh> meshes = import_meshes(files);
    for (std::size_t i = 0; i < files.size(); ++i) arm_meshes_[files[i]] = std::move(meshes[i]);
  }

  void write_link_shapes(const LinkDescription& link, const std::string& name, bool touches) {
    for (std::size_t i = 0; i < link.visuals.size(); ++i) {
      write_link_shape(link.visuals[i], fmt::format("{}_visual{}", name, i), 2);
    }
    for (std::size_t i = 0; i < link.collisions.size(); ++i) {
      if (touches) robot_hulls_.push_back(fmt::format("{}_hull{}", name, i));
      write_link_shape(link.collisions[i], fmt::format("{}_hull{}", name, i), 3);
    }
  }

  void write_link_shape(const LinkShape& shape, const std::string& name, int group) {
    const std::string place = pose(shape.T_link_shape);
    if (const auto* mesh = std::get_if<LinkShape::Mesh>(&shape.geometry)) {
      const std::string asset =
          fmt::format("{}_{}", group == 2 ? "seen" : "hull", mesh->file.stem().string());
      add_mesh_geom(name, add_mesh(asset, arm_meshes_.at(mesh->file), group == 2), group,
                    text(shape.colour), place);
      return;
    }
    std::string size;
    if (const auto* cylinder = std::get_if<LinkShape::Cylinder>(&shape.geometry)) {
      size =
          fmt::format("type=\"cylinder\" size=\"{} {}\"", cylinder->radius, 0.5 * cylinder->length);
    } else if (const auto* sphere = std::get_if<LinkShape::Sphere>(&shape.geometry)) {
      size = fmt::format("type=\"sphere\" size=\"{}\"", sphere->radius);
    } else {
      const Eigen::Vector3d half = 0.5 * std::get<LinkShape::Box>(shape.geometry).size;
      size = fmt::format("type=\"box\" size=\"{}\"", text(half));
    }
    bodies_ += fmt::format("<geom name=\"{}\" {} {} group=\"{}\" rgba=\"{}\"/>\n", name, size,
                           place, group, text(shape.colour));
  }

  void write_gripper() {
    const GripperDescription& gripper = parts_.gripper;
    bodies_ += fmt::format("<body name=\"gripper\" {}>\n", pose(parts_.arm.T_link7_flange));
    bodies_ += inertial(gripper.body);
    const TriangleMesh housing =
        box_mesh(gripper.body_size, {0.0, 0.0, 0.5 * gripper.body_size.z()});
    add_mesh("housing", housing, true);
    add_mesh_geom("housing", "housing", 2, "0.20 0.21 0.23 1");
    robot_hulls_.insert(robot_hulls_.end(), {"housing", "finger_left", "finger_right"});
    add_mesh("finger_left", finger(1.0), true);
    add_mesh("finger_right", finger(-1.0), true);
    add_mesh("pad_left", pad(1.0), true);
    add_mesh("pad_right", pad(-1.0), true);
    bodies_ += fmt::format("<site name=\"tcp\" {} size=\"0.004\" group=\"5\"/>\n",
                           pose(gripper.T_flange_tcp));
    for (const double side : {1.0, -1.0}) {
      const char* name = side > 0.0 ? "left" : "right";
      bodies_ += fmt::format(
          "<body name=\"jaw_{0}\" {1}>\n"
          "<joint name=\"jaw_{0}\" type=\"slide\" axis=\"0 {2} 0\" range=\"{3} {4}\" "
          "armature=\"{5}\" damping=\"{6}\"/>\n",
          name, pose(gripper.T_flange_tcp), side, 0.5 * gripper.stroke.low,
          0.5 * gripper.stroke.high, kJawArmature, kJawDamping);
      bodies_ += inertial(jaw_inertia(side));
      add_mesh_geom(fmt::format("finger_{}", name), fmt::format("finger_{}", name), 2,
                    "0.62 0.64 0.66 1");
      add_mesh_geom(fmt::format("pad_{}", name), fmt::format("pad_{}", name), 2,
                    "0.10 0.10 0.10 1");
      bodies_ += "</body>\n";
    }
    bodies_ += "</body>\n";
  }

  // The description's jaw is the left one; the right one is its mirror image.
  [[nodiscard]] BodyInertia jaw_inertia(double side) const {
    BodyInertia jaw = parts_.gripper.jaw;
    const Eigen::Vector3d mirror(1.0, side, 1.0);
    jaw.com = mirror.asDiagonal() * jaw.com;
    jaw.inertia = mirror.asDiagonal() * jaw.inertia * mirror.asDiagonal();
    return jaw;
  }

  // A straight finger with a bevelled tip; y points away from the pad's face.
  [[nodiscard]] TriangleMesh finger(double side) const {
    const GripperDescription& g = parts_.gripper;
    const double tip = g.tip_beyond_tcp;
    const double top = tip - g.finger_length;
    const double outer = g.finger_thickness;
    const double bevel = 0.35 * (outer - kPadThickness);
    return prism({{side * kPadThickness, top},
                  {side * outer, top},
                  {side * outer, tip - bevel},
                  {side * (outer - bevel), tip},
                  {side * (kPadThickness + 0.3 * bevel), tip},
                  {side * kPadThickness, tip - 0.3 * bevel}},
                 g.pad_width);
  }

  [[nodiscard]] TriangleMesh pad(double side) const {
    const GripperDescription& g = parts_.gripper;
    const double half = 0.5 * g.pad_height;
    const double bevel = 0.001;
    return prism({{side * kPadThickness, -half},
                  {side * kPadThickness, half},
                  {side * bevel, half},
                  {0.0, half - bevel},
                  {0.0, -half + bevel},
                  {side * bevel, -half}},
                 g.pad_width);
  }

  void write_object(std::size_t i) {
    const ObjectModel& model = parts_.objects[i];
    const double mass = model.physics.mass.centre();
    bodies_ +=
        fmt::format("<body name=\"object{0}\" pos=\"0 0 {1}\"><freejoint name=\"object{0}\"/>\n", i,
                    50.0 + static_cast<double>(i));
    bodies_ += inertial({mass, model.physics.p_model_com, mass * model.physics.inertia_per_mass});
    add_mesh_geom(fmt::format("object{}_seen", i), add_mesh("seen_" + model.name, model.mesh, true),
                  2, text(model.colour));
    for (std::size_t k = 0; k < model.collision.size(); ++k) {
      const std::string mesh =
          add_mesh(fmt::format("hull{}_{}", k, model.name), model.collision[k], false);
      hulls_.push_back({fmt::format("object{}_hull{}", i, k), i});
      add_mesh_geom(hulls_.back().name, mesh, 3, text(model.colour));
    }
    const std::vector<Eigen::Vector3d> points = support_points(model.collision, kPointSpacing);
    const Eigen::Vector3d centre = model.physics.p_model_com;
    for (std::size_t k = 0; k < points.size(); ++k) {
      points_.push_back({fmt::format("object{}_point{}", i, k), i, points.size() > kMostCorners});
      const Eigen::Vector3d inward = (centre - points[k]).normalized();
      bodies_ +=
          fmt::format("<geom name=\"{}\" type=\"sphere\" size=\"{}\" pos=\"{}\" group=\"3\"/>\n",
                      points_.back().name, kPointRadius,
                      text(Eigen::Vector3d(points[k] + kPointRadius * inward)));
    }
    bodies_ += "</body>\n";
  }

  void add_pair(const std::string& first, const std::string& second, int condim) {
    pairs_ += fmt::format(
        "<pair geom1=\"{}\" geom2=\"{}\" condim=\"{}\" friction=\"0.3 0.3 {} {} {}\" "
        "solref=\"0.005 1\"/>\n",
        first, second, condim, kSpinFriction, kRollingFriction, kRollingFriction);
  }

  void write_pairs() {
    for (const std::string& robot : robot_hulls_) {
      add_pair("table", robot, 3);
      for (const std::string& wall : walls_) add_pair(wall, robot, 3);
      for (const ObjectGeom& hull : hulls_) add_pair(robot, hull.name, 3);
    }
    for (const ObjectGeom& point : points_) add_pair("table", point.name, point.rolls ? 6 : 3);
    for (std::size_t i = 0; i < hulls_.size(); ++i) {
      for (const std::string& wall : walls_) add_pair(wall, hulls_[i].name, 4);
      for (const char* pad : {"pad_left", "pad_right"}) add_pair(pad, hulls_[i].name, 4);
      for (std::size_t k = i + 1; k < hulls_.size(); ++k) {
        if (hulls_[i].object != hulls_[k].object) add_pair(hulls_[i].name, hulls_[k].name, 6);
      }
    }
  }

  [[nodiscard]] std::string actuators() const {
    std::string text =
        "<tendon><fixed name=\"width\"><joint joint=\"jaw_left\" coef=\"1\"/>"
        "<joint joint=\"jaw_right\" coef=\"1\"/></fixed></tendon>\n"
        "<equality><joint joint1=\"jaw_left\" joint2=\"jaw_right\" polycoef=\"0 1 0 0 0\" "
        "solref=\"0.002 1\" solimp=\"0.99 0.999 0.001\"/></equality>\n<actuator>\n";
    for (std::size_t i = 0; i < parts_.arm.joints.size(); ++i) {
      const double effort = parts_.arm.joints[i].effort;
      text += fmt::format("<motor name=\"motor{0}\" joint=\"joint{0}\" ctrlrange=\"{1} {2}\"/>\n",
                          i + 1, -effort, effort);
    }
    text +=
        fmt::format("<motor name=\"drive\" tendon=\"width\" ctrlrange=\"{} {}\"/>\n</actuator>\n",
                    -parts_.gripper.max_force, parts_.gripper.max_force);
    return text;
  }

  struct ObjectGeom {
    std::string name;
    std::size_t object;
    bool rolls = false;
  };

  const WorldParts& parts_;
  WorldSource source_;
  std::string assets_;
  std::string bodies_;
  std::string pairs_;
  std::vector<std::string> walls_;
  std::vector<ObjectGeom> hulls_;
  std::vector<ObjectGeom> points_;
  std::vector<std::string> robot_hulls_;
  std::map<std::filesystem::path, TriangleMesh> arm_meshes_;
};

}  // namespace

WorldSource write_world(const WorldParts& parts) { return WorldWriter(parts).write(); }

}  // namespace binpick
