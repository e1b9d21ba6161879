#include "sim/renderer.h"

#include <GL/osmesa.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <stdexcept>

namespace binpick {
namespace {

// The depth buffer's 24 bits give steps of 1.2 um at 1 m with these planes.
constexpr double kDepthNear = 0.05;  // m
constexpr double kDepthFar = 2.5;    // m
constexpr double kPictureNear = 0.1;
constexpr double kPictureFar = 15.0;
constexpr int kMaxGeoms = 2000;

struct OsMesaDeleter {
  void operator()(osmesa_context* context) const noexcept { OSMesaDestroyContext(context); }
};

// llvmpipe's own threads only get in the way of one worker per core. It reads the variable when the
// first context is made; a value that the user set stays.
void keep_rasterizer_on_this_thread() {
  static std::once_flag once;
  std::call_once(once, [] { setenv("LP_NUM_THREADS", "0", 0); });
}

}  // namespace

struct Renderer::Context {
  std::shared_ptr<const WorldTemplate> shared;
  std::vector<unsigned char> window;  // OSMesa wants a buffer even for off-screen targets
  std::unique_ptr<osmesa_context, OsMesaDeleter> gl;
  mjrContext render{};
  mjvScene scene{};
  std::vector<float> depth;
  std::vector<std::uint8_t> colours;
  int max_width = 0;
  int max_height = 0;

  Context(std::shared_ptr<const WorldTemplate> shared_template, int width, int height)
      : shared(std::move(shared_template)), max_width(width), max_height(height) {
    keep_rasterizer_on_this_thread();
    install_mujoco_handlers();
    const std::array<int, 9> attributes{
        OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 24, OSMESA_STENCIL_BITS, 8, 0, 0};
    gl.reset(OSMesaCreateContextAttribs(attributes.data(), nullptr));
    if (!gl) throw std::runtime_error("OSMesa cannot make a GL context");
    window.resize(std::size_t{4} * 64 * 64);
    make_current();
    MjModelPtr model(mj_copyModel(nullptr, shared->model.get()));
    model->vis.global.offwidth = width;
    model->vis.global.offheight = height;
    mjr_defaultContext(&render);
    mjv_defaultScene(&scene);
    mjv_makeScene(model.get(), &scene, kMaxGeoms);
    mjr_makeContext(model.get(), &render, mjFONTSCALE_50);
    mjr_setBuffer(mjFB_OFFSCREEN, &render);
    if (render.currentBuffer != mjFB_OFFSCREEN) {
      throw std::runtime_error("OSMesa offers no off-screen buffer");
    }
  }

  ~Context() {
    if (gl && OSMesaMakeCurrent(gl.get(), window.data(), GL_UNSIGNED_BYTE, 64, 64) != 0) {
      mjr_freeContext(&render);
    }
    mjv_freeScene(&scene);
  }

  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  void make_current() {
    if (OSMesaMakeCurrent(gl.get(), window.data(), GL_UNSIGNED_BYTE, 64, 64) == 0) {
      throw std::runtime_error("OSMesa cannot make its GL context current");
    }
  }

  // Fills the abstract scene as `view` sees the world. Depth needs no textures, which cost time.
  void update(World& world, View view, bool textures) {
    const bool picture = view == View::kPicture;
    world.refresh_poses();
    mjvOption option;
    mjv_defaultOption(&option);
    for (int group = 0; group < mjNGROUP; ++group) {
      option.geomgroup[group] = group == 2 || (group == 4 && picture);
      option.sitegroup[group] = 0;
    }
    option.flags[mjVIS_TEXTURE] = textures;
    mjvCamera camera;
    mjv_defaultCamera(&camera);
    camera.type = mjCAMERA_FIXED;
    camera.fixedcamid =
        mj_name2id(&world.model(), mjOBJ_CAMERA, picture ? "picture" : "depth_camera");
    mjv_updateScene(&world.model(), &world.mutable_data(), &option, nullptr, &camera, mjCAT_ALL,
                    &scene);
    set_planes(picture ? kPictureNear : kDepthNear, picture ? kPictureFar : kDepthFar);
  }

  // The frustum is given on its near plane: moving the plane scales it.
  void set_planes(double near_plane, double far_plane) {
    for (mjvGLCamera& camera : scene.camera) {
      const float scale = static_cast<float>(near_plane) / camera.frustum_near;
      camera.frustum_top *= scale;
      camera.frustum_bottom *= scale;
      camera.frustum_center *= scale;
      camera.frustum_near = static_cast<float>(near_plane);
      camera.frustum_far = static_cast<float>(far_plane);
    }
  }

  void draw(int width, int height) {
    if (width > max_width || height > max_height) {
      throw std::invalid_argument("the image is larger than the renderer was made for");
    }
    mjr_render({0, 0, width, height}, &scene, &render);
  }

  void set_flags(bool shadows, bool segments) {
    std::fill(std::begin(scene.flags), std::end(scene.flags), mjtByte{0});
    scene.flags[mjRND_CULL_FACE] = 1;
    scene.flags[mjRND_SHADOW] = shadows;
    scene.flags[mjRND_SKYBOX] = shadows;
    scene.flags[mjRND_SEGMENT] = segments;
    scene.flags[mjRND_IDCOLOR] = segments;
  }
};

Renderer::Renderer(std::shared_ptr<const WorldTemplate> shared, int max_width, int max_height)
    : context_(std::make_unique<Context>(std::move(shared), max_width, max_height)) {}

Renderer::~Renderer() = default;

DepthImage Renderer::depth(World& world, View view, int width, int height) {
  Context& context = *context_;
  context.make_current();
  context.update(world, view, false);
  context.set_flags(false, false);
  context.draw(width, height);
  const auto columns = static_cast<std::size_t>(width);
  context.depth.resize(columns * static_cast<std::size_t>(height));
  mjr_readPixels(nullptr, context.depth.data(), {0, 0, width, height}, &context.render);
  DepthImage image{width, height, std::vector<float>(context.depth.size())};
  const double near_plane = context.scene.camera[0].frustum_near;
  const double far_plane = context.scene.camera[0].frustum_far;
  // z = n f / (f - d (f - n)), and nothing at d = 1. Rows come from the bottom.
  const auto product = static_cast<float>(near_plane * far_plane);
  const auto far_z = static_cast<float>(far_plane);
  const auto span = static_cast<float>(far_plane - near_plane);
  for (int row = 0; row < height; ++row) {
    const float* from = context.depth.data() + columns * static_cast<std::size_t>(height - 1 - row);
    float* to = image.z.data() + columns * static_cast<std::size_t>(row);
    for (std::size_t i = 0; i < columns; ++i) {
      to[i] = from[i] < 1.0f ? product / (far_z - from[i] * span) : 0.0f;
    }
  }
  return image;
}

ColourImage Renderer::colour(World& world, View view, int width, int height) {
  Context& context = *context_;
  context.make_current();
  context.update(world, view, true);
  context.set_flags(true, false);
  context.draw(width, height);
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(width);
  context.colours.resize(row_bytes * static_cast<std::size_t>(height));
  mjr_readPixels(context.colours.data(), nullptr, {0, 0, width, height}, &context.render);
  ColourImage image{width, height, std::vector<std::uint8_t>(context.colours.size())};
  for (int row = 0; row < height; ++row) {
    std::copy_n(context.colours.data() + row_bytes * static_cast<std::size_t>(height - 1 - row),
                row_bytes, image.rgb.data() + row_bytes * static_cast<std::size_t>(row));
  }
  return image;
}

SegmentationImage Renderer::segmentation(World& world, View view, int width, int height) {
  Context& context = *context_;
  context.make_current();
  context.update(world, view, false);
  context.set_flags(false, true);
  context.draw(width, height);
  const auto columns = static_cast<std::size_t>(width);
  context.colours.resize(3 * columns * static_cast<std::size_t>(height));
  mjr_readPixels(context.colours.data(), nullptr, {0, 0, width, height}, &context.render);
  // A pixel's colour is one more than the identifier that its geom has in the abstract scene.
  std::vector<std::int16_t> meaning(static_cast<std::size_t>(context.scene.ngeom) + 1,
                                    SegmentationImage::kBackground);
  for (int i = 0; i < context.scene.ngeom; ++i) {
    const mjvGeom& geom = context.scene.geoms[i];
    if (geom.segid < 0 || geom.segid >= context.scene.ngeom || geom.objtype != mjOBJ_GEOM) continue;
    const int owner = world.shared().index.geom_object[static_cast<std::size_t>(geom.objid)];
    std::int16_t value = static_cast<std::int16_t>(owner);
    if (owner == WorldIndex::kCell) value = SegmentationImage::kCell;
    if (owner == WorldIndex::kRobot) value = SegmentationImage::kRobot;
    meaning[static_cast<std::size_t>(geom.segid) + 1] = value;
  }
  SegmentationImage image{width, height, {}};
  image.object.reserve(columns * static_cast<std::size_t>(height));
  for (int row = height - 1; row >= 0; --row) {
    for (std::size_t i = 0; i < columns; ++i) {
      const std::uint8_t* rgb =
          context.colours.data() + 3 * (columns * static_cast<std::size_t>(row) + i);
      const std::size_t id = rgb[0] + 256u * rgb[1] + 65536u * rgb[2];
      image.object.push_back(id < meaning.size() ? meaning[id] : SegmentationImage::kBackground);
    }
  }
  return image;
}

}  // namespace binpick
