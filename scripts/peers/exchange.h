#pragma once

// The files through which recognizers that are strangers to each other work on the same scenes, and
// a process of its own for every scene.
//
// A folder holds, lengths in metres, poses in the camera's frame (x right, y down, z forward):
//   models.txt             a line per model: name, diameter
//   NAME.ply               the model's triangles
//   NAME.txt               its oriented points: x y z nx ny nz
//   scene_K.pcd            the scan with the table; scene_K_cut.pcd with the table cut away
//   scene_K_truth.txt      a line per object: name, visible share, whether it is all in the image,
//                          and the upper three rows of T_camera_model, row by row
//   scene_K_ROW.txt        what the recognizer of a row of the table found: seconds, peak memory in
//                          kB and status, then a line per object: name and T_camera_model

#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace peers {

using Pose = std::array<double, 12>;

struct Model {
  std::string name;
  double diameter = 0.0;
};

struct OrientedPoint {
  std::array<float, 3> p{}, n{};
};

/// A scan; NaN where nothing was measured.
struct Scan {
  std::vector<std::array<float, 3>> points;
  int width = 0;
  int height = 0;
};

struct Object {
  std::string model;
  double visible_share = 1.0;
  bool in_frame = true;
  Pose T_camera_model{};
};

struct Answer {
  double seconds = 0.0;  ///< of processor; reading of files and preparation of models excluded
  long peak_kilobytes = 0;
  std::string status = "ok";
  std::vector<Object> objects;
};

inline std::ifstream open(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + ": cannot be read");
  return in;
}

inline std::vector<Model> read_models(const std::string& folder) {
  std::ifstream in = open(folder + "/models.txt");
  std::vector<Model> models;
  for (Model model; in >> model.name >> model.diameter;) models.push_back(model);
  return models;
}

inline std::vector<OrientedPoint> read_oriented_points(const std::string& file) {
  std::ifstream in = open(file);
  std::vector<OrientedPoint> points;
  for (OrientedPoint o; in >> o.p[0] >> o.p[1] >> o.p[2] >> o.n[0] >> o.n[1] >> o.n[2];) {
    points.push_back(o);
  }
  return points;
}

/// Reads what write_scan wrote.
inline Scan read_scan(const std::string& file) {
  std::ifstream in = open(file);
  Scan scan;
  std::size_t count = 0;
  for (std::string line; std::getline(in, line) && line != "DATA binary";) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "WIDTH") words >> scan.width;
    if (key == "HEIGHT") words >> scan.height;
    if (key == "POINTS") words >> count;
  }
  scan.points.resize(count);
  in.read(reinterpret_cast<char*>(scan.points.data()), static_cast<std::streamsize>(12 * count));
  if (!in) throw std::runtime_error(file + ": ends too early");
  return scan;
}

inline void write_scan(const std::string& file, const Scan& scan) {
  std::ofstream out(file);
  out << "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH "
      << scan.width << "\nHEIGHT " << scan.height << "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS "
      << scan.points.size() << "\nDATA binary\n";
  out.write(reinterpret_cast<const char*>(scan.points.data()),
            static_cast<std::streamsize>(12 * scan.points.size()));
}

inline std::string scene_file(const std::string& folder, int scene, const std::string& rest) {
  return folder + "/scene_" + std::to_string(scene) + rest;
}

inline std::vector<Object> read_truth(const std::string& folder, int scene) {
  std::ifstream in = open(scene_file(folder, scene, "_truth.txt"));
  std::vector<Object> objects;
  for (Object o; in >> o.model >> o.visible_share >> o.in_frame;) {
    for (double& value : o.T_camera_model) in >> value;
    objects.push_back(o);
  }
  return objects;
}

inline void write_answer(const std::string& file, const Answer& answer) {
  std::ofstream out(file);
  out.precision(9);
  out << answer.seconds << ' ' << answer.peak_kilobytes << ' ' << answer.status << '\n';
  for (const Object& object : answer.objects) {
    out << object.model;
    for (const double value : object.T_camera_model) out << ' ' << value;
    out << '\n';
  }
}

inline Answer read_answer(const std::string& file) {
  std::ifstream in = open(file);
  Answer answer;
  in >> answer.seconds >> answer.peak_kilobytes >> answer.status;
  for (Object object; in >> object.model;) {
    for (double& value : object.T_camera_model) in >> value;
    answer.objects.push_back(object);
  }
  return answer;
}

/// Processor time of this process, which a busy machine does not lengthen: everybody runs on one
/// thread.
class Clock {
 public:
  [[nodiscard]] double seconds() const { return now() - start_; }

 private:
  static double now() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  double start_ = now();
};

/// Lets `recognize(scan, scene)` work on every scene, each in a child process that ends after
/// `limit` seconds of processor time; a crash or the limit becomes the answer's status.
inline void answer_scenes(const std::string& folder, const std::string& row, bool cut, int limit,
                          const std::function<Answer(const Scan&, int scene)>& recognize) {
  for (int scene = 0;; ++scene) {
    const std::string scan_file = scene_file(folder, scene, cut ? "_cut.pcd" : ".pcd");
    if (!std::ifstream(scan_file)) return;
    const std::string answer_file = scene_file(folder, scene, "_" + row + ".txt");
    std::remove(answer_file.c_str());
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) {
      const rlimit time = {static_cast<rlim_t>(limit), static_cast<rlim_t>(limit)};
      setrlimit(RLIMIT_CPU, &time);
      const Scan scan = read_scan(scan_file);
      write_answer(answer_file, recognize(scan, scene));
      std::_Exit(0);
    }
    int status = 0;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    Answer answer;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      answer = read_answer(answer_file);
    } else {
      const bool too_long =
          WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
      answer.status = too_long ? "timeout" : "crash";
      answer.seconds = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec);
    }
    answer.peak_kilobytes = usage.ru_maxrss;
    write_answer(answer_file, answer);
    std::cerr << row << " scene " << scene << ": " << answer.objects.size() << " objects, "
              << answer.seconds << " s, " << answer.status << '\n';
  }
}

}  // namespace peers
