#include "scenes/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/parallel.h"
#include "coupling/world.h"
#include "scenes/background_writer.h"
#include "scenes/checkpoint.h"
#include "scenes/disk_estimate.h"
#include "scenes/effective_scene.h"
#include "scenes/frame_output.h"
#include "scenes/machine.h"
#include "scenes/manifest.h"
#include "scenes/metrics.h"
#include "scenes/motion_output.h"
#include "scenes/progress.h"
#include "scenes/run_folder.h"
#include "scenes/run_record.h"
#include "scenes/scene_file.h"
#include "scenes/sha256.h"
#include "scenes/signals.h"
#include "scenes/version.h"

namespace wick::scenes {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string hex(std::uint64_t value) {
  return fmt::format("{:016x}", value);
}

/// One run of one scene into one folder.
class Run {
 public:
  Run(const RunOptions& options, Scene scene)
      : options_(options),
        scene_(std::move(scene)),
        folder_{output_folder(options, scene_)},
        identity_(scene_identity(scene_)),
        world_(std::make_unique<coupling::World>(scene_.world)) {
    record_.threads = thread_count();
    record_.scene_sha256 = sha256(identity_);
    record_.models = world_->models();
  }

  ExitCode execute() {
    require_disk(estimate_disk(*world_, scene_), folder_.root);
    make_folder(folder_.root);
    const FolderLock lock(folder_.root);
    folder_.require_free_names();
    folder_.tidy();
    if (options_.restart) folder_.clear();
    const bool resumed = resume();
    if (resumed && world_->frame() >= scene_.frames) return already_complete();
    folder_.make(scene_);
    write_file(folder_.scene(), effective_file(scene_, folder_.root));
    try {
      write_record("running");
      if (!resumed) write_frame(first_report(), true);
      return compute();
    } catch (const std::exception& error) {
      fail(error);
      throw;
    }
  }

 private:
  /// Goes on from the newest checkpoint that is whole, or from one before the first output that is damaged; false
  /// where there is no checkpoint.
  bool resume() {
    const std::vector<int> frames = checkpoint_frames(folder_.checkpoints());
    if (!resume_from(frames)) {
      require_no_other_record();
      return false;
    }
    const std::vector<DamagedOutput> damaged = damaged_outputs();
    if (damaged.empty()) return true;
    for (const DamagedOutput& output : damaged) record_.damaged_outputs.push_back(output.file);
    int first = damaged.front().frame;
    for (const DamagedOutput& output : damaged) first = std::min(first, output.frame);
    std::vector<int> before = frames;
    std::erase_if(before, [&](int frame) { return frame >= first; });
    const int reached = world_->frame();
    forget();
    if (resume_from(before)) {
      warn(fmt::format("outputs are missing or damaged and will be made again: {}", summary_of(damaged)));
    } else {
      warn(fmt::format(
          "outputs are missing or damaged: {}; no checkpoint is left from before frame {}, so they stay "
          "so (--restart makes all anew)",
          summary_of(damaged), first));
      std::vector<int> last = frames;
      std::erase_if(last, [&](int frame) { return frame > reached; });
      if (!resume_from(last)) throw std::runtime_error("a checkpoint that could be read cannot be read again");
    }
    manifest_.keep_up_to(world_->frame());
    return true;
  }

  /// What the manifest tells of the frames before the checkpoint; nothing where there is no manifest to tell.
  std::vector<DamagedOutput> damaged_outputs() {
    try {
      manifest_ = Manifest::read(folder_.manifest());
    } catch (const std::exception& error) {
      warn(fmt::format("{} cannot be used ({}): earlier outputs are not verified", folder_.manifest().string(),
                       error.what()));
      return {};
    }
    manifest_.keep_up_to(world_->frame());
    return manifest_.damaged(folder_.root, [] { return stop_requested(); });
  }

  bool resume_from(const std::vector<int>& frames) {
    for (const int frame : frames) {
      const fs::path path = folder_.checkpoints() / checkpoint_name(frame);
      try {
        const Checkpoint checkpoint(path);
        require_same_run(checkpoint.header());
        restore(checkpoint);
        return true;
      } catch (const Refusal& refusal) {
        if (refusal.code() == ExitCode::output_cannot_be_made) throw;
        skip_checkpoint(path, refusal.what());
      } catch (const std::bad_alloc&) {
        throw;
      } catch (const std::exception& error) {
        skip_checkpoint(path, error.what());
      }
    }
    return false;
  }

  void skip_checkpoint(const fs::path& path, const std::string& why) {
    warn(fmt::format("checkpoint {} cannot be used ({}); trying the one before", path.string(), why));
    forget();
  }

  /// Back to a world as the scene gives it: reading a checkpoint may have got half-way.
  void forget() {
    world_ = std::make_unique<coupling::World>(scene_.world);
    metrics_ = Metrics();
  }

  void require_same_run(const CheckpointHeader& header) const {
    const std::string difference = identity_difference(header.identity, identity_);
    require(difference.empty(), "",
            fmt::format("{} holds another run ({}) choose another --out, or --restart to replace it",
                        folder_.root.string(), difference),
            ExitCode::output_cannot_be_made);
    require(
        header.version == version, "",
        fmt::format("{} was begun by wick {}, this is {} (the state may mean something else) choose another --out, "
                    "or --restart to replace it",
                    folder_.root.string(), header.version, version),
        ExitCode::output_cannot_be_made);
  }

  void restore(const Checkpoint& checkpoint) {
    checkpoint.read([&](StateVisitor& v) { metrics_.visit(v); }, [&](StateVisitor& v) { world_->visit(v); });
    world_->restored();
    if (world_->frame() != checkpoint.header().frame || world_->state_hash() != checkpoint.header().state_hash)
      throw std::runtime_error("it does not give back the state that it recorded");
    last_checkpoint_ = world_->time();
    record_.frames = world_->frame();
    record_.unconverged_solves = 0;
    record_.state_hash = hex(metrics_.last_hash());
    if (const auto* unconverged = metrics_.column("/unconverged_solves"))
      for (const double count : *unconverged) record_.unconverged_solves += static_cast<long long>(count);
  }

  /// Without a checkpoint, the record of the folder still tells whose it is.
  void require_no_other_record() const {
    if (!fs::exists(folder_.record())) return;
    const Bytes bytes = read_file(folder_.record(), 16 << 20);
    const auto json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
    if (!json.is_object()) return;
    require(
        json.value("scene_sha256", record_.scene_sha256) == record_.scene_sha256, "",
        fmt::format("{} holds another run (its run.json names another scene) choose another --out, or --restart to "
                    "replace it",
                    folder_.root.string()),
        ExitCode::output_cannot_be_made);
  }

  ExitCode already_complete() {
    if (!options_.quiet)
      fmt::print(
          "{} is complete: it has {} frames and {} were asked for (--frames for more, --restart to begin anew)\n",
          folder_.root.string(), world_->frame(), scene_.frames);
    // A run killed between its last checkpoint and its record left the record behind; metrics may have been lost
    // since.
    write_file(folder_.metrics(), metrics_.file());
    write_motion();
    if (!said_done() || !record_.damaged_outputs.empty()) write_record("done");
    return ExitCode::done;
  }

  [[nodiscard]] bool said_done() const {
    if (!fs::exists(folder_.record())) return false;
    const Bytes bytes = read_file(folder_.record(), 16 << 20);
    const auto json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
    return json.is_object() && json.value("outcome", "") == "done";
  }

  [[nodiscard]] coupling::FrameReport first_report() const {
    coupling::FrameReport report;
    report.frame = world_->frame();
    report.time = world_->time();
    return report;
  }

  ExitCode compute() {
    Progress progress(world_->frame(), scene_.frames, options_.quiet);
    if (world_->frame() > 1)
      progress.note(fmt::format("going on from frame {} in {}", world_->frame(), folder_.root.string()));
    while (world_->frame() < scene_.frames && !stop_requested()) {
      const auto start = Clock::now();
      coupling::FrameReport report =
          world_->step(1.0 / scene_.fps, [] { return stop_requested() || checkpoint_requested(); });
      if (!report.complete) {
        write_checkpoint();
        continue;
      }
      const auto stepped = Clock::now();
      write_frame(report, false);
      report.seconds["output"] = seconds_since(stepped);
      progress.frame(report, seconds_since(start));
    }
    const bool done = world_->frame() >= scene_.frames;
    finish_writing();
    if (done) write_motion();
    if (record_.unconverged_solves > 0)
      warn(fmt::format(
          "{} solves stopped at their iteration limit, above their tolerance (see /solve in metrics.h5)",
          record_.unconverged_solves));
    if (squeezed_steps_ > 0)
      warn(fmt::format(
          "in {} steps closed walls pushed more gas in than out, which cannot flow anywhere: open a side of "
          "/smoke/sides, or keep obstacles from entering a closed box",
          squeezed_steps_));
    if (lengthened_steps_ > 0)
      warn(
          fmt::format("{} steps were longer than asked (/coupling/max_substeps cut them off): raise it, or shorten "
                      "the frame",
                      lengthened_steps_));
    write_record(done ? "done" : "checkpointed");
    progress.summary(seconds_since(start_));
    if (!options_.quiet)
      fmt::print("{}: {} frames in {}, state {}, last checkpoint in {:.2f} s{}\n", folder_.root.string(),
                 world_->frame(), seconds_text(seconds_since(start_)), record_.state_hash, record_.checkpoint_s,
                 done ? "" : "; stopped on request, the same command goes on");
    return done ? ExitCode::done : ExitCode::checkpointed;
  }

  /// Checks the state, then hands everything that the frame writes to the writer's thread.
  void write_frame(const coupling::FrameReport& report, bool first) {
    require_finite();
    const std::uint64_t hash = world_->state_hash();
    metrics_.add(metrics_row(*world_, report), hash);
    FrameOutput output = gather_outputs(*world_, scene_, folder_, record_.scene_sha256);
    output.metrics = metrics_.file();
    const int frame = world_->frame(), every = scene_.output.checkpoint.every;
    const bool last = frame >= scene_.frames || stop_requested();
    if (first || last || (every > 0 && frame % every == 0) || take_checkpoint_request()) add_checkpoint(output);
    submit(std::move(output));
    record_.frames = frame;
    record_.state_hash = hex(hash);
    record_.unconverged_solves += report.unconverged_solves;
    lengthened_steps_ += report.lengthened_steps;
    squeezed_steps_ += report.squeezed_steps;
  }

  void add_checkpoint(FrameOutput& output) {
    const auto start = Clock::now();
    const CheckpointHeader header{world_->frame(), world_->time(), version, identity_, world_->state_hash()};
    output.checkpoint = make_checkpoint(
        header, [&](StateVisitor& v) { metrics_.visit(v); }, [&](StateVisitor& v) { world_->visit(v); });
    output.checkpoint_seconds = seconds_since(start);
    last_checkpoint_ = world_->time();
  }

  /// Saves the state as it is, in the middle of a frame too.
  void write_checkpoint() {
    require_finite();
    take_checkpoint_request();
    FrameOutput output;
    output.frame = world_->frame();
    add_checkpoint(output);
    submit(std::move(output));
  }

  void submit(FrameOutput output) {
    writer_.submit([this, output = std::make_shared<FrameOutput>(std::move(output))] {
      const double seconds = write_outputs(*output, scene_.output, folder_, manifest_);
      if (!output->checkpoint.empty()) record_.checkpoint_s = output->checkpoint_seconds + seconds;
    });
  }

  /// Waits for the writer; a stop that came after the last frame was handed over still gets its checkpoint.
  void finish_writing() {
    if (last_checkpoint_ != world_->time()) write_checkpoint();
    writer_.finish();
  }

  /// Joins what the frames recorded of the movement, once the writer's thread is done.
  void write_motion() {
    const std::vector<DamagedOutput> missing = join_motion(*world_, scene_, folder_, manifest_);
    if (!missing.empty()) warn(fmt::format("recorded motion has gaps: {}", summary_of(missing)));
  }

  void require_finite() {
    FiniteCheck check;
    world_->visit(check);
    if (check.first().empty()) return;
    throw Refusal(
        ExitCode::numerical_failure, "",
        fmt::format("the state is no longer finite in frame {} at {:.6g} s ({}) earlier frames and checkpoints "
                    "stay; try a finer step or softer material",
                    world_->frame(), world_->time(), check.first()));
  }

  void warn(const std::string& text) {
    record_.warnings.push_back(text);
    if (!options_.quiet) fmt::print(stderr, "wick: warning: {}\n", text);
  }

  void write_record(const std::string& outcome) {
    record_.outcome = outcome;
    record_.wall_s = seconds_since(start_);
    write_file(folder_.record(), run_record_text(record_));
  }

  /// Leaves the reason behind, as far as the disk still takes it.
  void fail(const std::exception& error) {
    try {
      writer_.finish();
    } catch (const std::exception&) {
      // The error that is being reported already, or one that follows from it.
    }
    try {
      record_.reason = error.what();
      write_record("failed");
    } catch (const std::exception&) {
      // The caller reports the first error; a record that cannot be written keeps saying "running".
    }
  }

  const RunOptions& options_;
  Scene scene_;
  RunFolder folder_;
  std::string identity_;
  std::unique_ptr<coupling::World> world_;
  Metrics metrics_;
  RunRecord record_;
  Clock::time_point start_ = Clock::now();
  Manifest manifest_;            ///< belongs to the writer's thread once frames are computed
  double last_checkpoint_ = -1;  ///< simulated time of the state that was saved last [s]
  long long lengthened_steps_ = 0;
  long long squeezed_steps_ = 0;
  BackgroundWriter writer_{1};
};

}  // namespace

fs::path output_folder(const RunOptions& options, const Scene& scene) {
  return options.out.empty() ? fs::path("out") / scene.name : fs::path(options.out);
}

Scene load_scene(const RunOptions& options) {
  Scene scene = read_scene(options.scene, options.set);
  if (options.frames) scene.frames = *options.frames;
  return scene;
}

/// A run writes the effective scene into its folder: that must not be the file that the user wrote.
void require_scene_stays(const RunOptions& options, const Scene& scene) {
  const RunFolder folder{options.out.empty() ? fs::path("out") / scene.name : fs::path(options.out)};
  std::error_code error;
  if (fs::equivalent(folder.scene(), options.scene, error))
    throw Refusal(ExitCode::output_cannot_be_made, "",
                  "--out is the folder of the scene file, which the effective scene would replace; choose another");
}

ExitCode run_scene(const RunOptions& options) {
  Scene scene = load_scene(options);
  require_scene_stays(options, scene);
  require_memory(scene);
  watch_signals();
  std::optional<ThreadLimit> limit;
  if (options.threads > 0) limit.emplace(options.threads);
  return Run(options, std::move(scene)).execute();
}

}  // namespace wick::scenes
