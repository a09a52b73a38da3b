// SPDX-License-Identifier: GPL-3.0-or-later
//
// Flamenco job type: bakes the Volume Lattices of a file in chunks on any number of workers, joins the chunks into
// caches, and renders the file that plays from them. Rendering needs no add-on; baking and joining need Isochor.

const JOB_TYPE = {
    label: "Isochor Bake and Render",
    description: "Bake Volume Lattices in chunks, then render the frames from the caches",
    settings: [
        // For artists to determine:
        { key: "frames", type: "string", required: true,
          eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
          evalInfo: {
            showLinkButton: true,
            description: "Scene frame range",
          },
          description: "Frames to render, such as '47', '1-30' or '3, 5-10'. All from the first to the last are baked" },
        { key: "bake_chunk_size", type: "int32", default: 20, propargs: {min: 1}, visible: "submission",
          description: "Number of frames to bake in one task" },
        { key: "chunk_size", type: "int32", default: 1, propargs: {min: 1}, visible: "submission",
          label: "Render Chunk Size", description: "Number of frames to render in one task" },
        { key: "objects", type: "string", default: "", visible: "submission",
          description: "Names of the objects to bake, separated by spaces, in quotes where a name has spaces itself. "
                     + "Empty: every object with a Volume Lattice" },
        { key: "cache_format", type: "string", choices: ["pc2", "mdd"], default: "pc2", visible: "submission",
          description: "File format of the caches" },
        { key: "samples", type: "int32", default: 1, propargs: {min: 1}, visible: "submission",
          description: "Samples to a frame in the caches; more than 1 for motion blur that follows a curve" },
        { key: "allow_problems", type: "bool", default: false, visible: "submission",
          description: "Do not fail where the volume could not be kept in some frame" },
        { key: "resume", type: "bool", default: true, visible: "submission",
          description: "Keep chunks that an earlier job of the same name has baked, where they are still valid" },
        { key: "report", type: "bool", default: true, visible: "submission",
          description: "Write the volume of every frame as CSV and PNG beside the caches" },
        { key: "render", type: "bool", default: true, visible: "submission",
          description: "Render the frames when the caches are there" },

        // render_output_root + add_path_components determine bake_path and render_output_path.
        { key: "render_output_root", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Base directory of the results. Will have some job-specific parts appended to it" },
        { key: "add_path_components", type: "int32", required: true, default: 0, propargs: {min: 0, max: 32},
          visible: "submission",
          description: "Number of path components of the current blend file to use in the output paths" },
        { key: "bake_path", type: "string", subtype: "dir_path", editable: false,
          eval: "str(Path(abspath(settings.render_output_root), "
              + "last_n_dir_parts(settings.add_path_components), jobname, 'isochor'))",
          description: "Directory of the chunks, the caches, the report and the baked blend file. The same for every "
                     + "job of this name, so that a job submitted again finds what there is" },
        { key: "render_output_path", type: "string", subtype: "file_path", editable: false,
          eval: "str(Path(abspath(settings.render_output_root), "
              + "last_n_dir_parts(settings.add_path_components), jobname, '{timestamp}', '######'))",
          description: "Final file path of where render output will be saved" },

        // Automatically evaluated settings:
        { key: "blendfile", type: "string", required: true, visible: "web",
          description: "Path of the blend file to bake and render" },
        { key: "format", type: "string", required: true, visible: "web",
          eval: "C.scene.render.image_settings.file_format",
          description: "File format of the rendered images" },
        { key: "scene", type: "string", required: true, visible: "web",
          eval: "C.scene.name",
          description: "Name of the scene to render" },
    ]
};

// File formats that hold more than one frame cannot be rendered in chunks.
const VIDEO_FORMATS = ["FFMPEG", "AVI_RAW", "AVI_JPEG"];

// The file extension follows the image format; a task that is run again keeps the frames it finds.
const RENDER_SETTINGS = [
    "import bpy",
    "render = bpy.context.scene.render",
    "render.use_file_extension = True",
    "render.use_overwrite = False",
    "render.use_placeholder = False",
].join("; ");

function compileJob(job) {
    const settings = job.settings;
    if (settings.render && VIDEO_FORMATS.indexOf(settings.format) >= 0) {
        throw `This job type renders images, the file is set to render "${settings.format}": choose an image format`;
    }
    settings.render_output_path = renderOutputPath(job);

    const bakes = authorBakes(settings);
    const join = authorJoin(settings);
    // A task is copied when it is added to the job: its dependencies have to be known by then.
    for (const bake of bakes) {
        join.addDependency(bake);
        job.addTask(bake);
    }
    job.addTask(join);

    if (settings.report) {
        job.addTask(authorReport(settings));
    }
    for (const render of settings.render ? authorRenders(settings) : []) {
        render.addDependency(join);
        job.addTask(render);
    }
}

// The path with the time at which the job was made, so that no job renders over another's frames.
function renderOutputPath(job) {
    if (!job.settings.render_output_path) {
        throw "no render_output_path setting!";
    }
    return job.settings.render_output_path.replace("{timestamp}", formatTimestampLocal(job.created));
}

function authorBakes(settings) {
    const whole = wholeRange(settings);
    return frameChunker(whole, settings.bake_chunk_size).map((chunk) => {
        const part = [`--frames=${range(chunk)}`, `--part-of=${whole}`].concat(settings.resume ? ["--resume"] : []);
        return isochorTask("bake", `bake-${range(chunk)}`, settings, part.concat(caches(settings), allowing(settings)));
    });
}

function authorJoin(settings) {
    const whole = [`--frames=${wholeRange(settings)}`, "--save", bakedFile(settings)];
    return isochorTask("join", "join", settings, whole.concat(caches(settings)));
}

function authorReport(settings) {
    return isochorTask("report", "report", settings, [`--frames=${wholeRange(settings)}`].concat(allowing(settings)));
}

function caches(settings) {
    return [`--format=${settings.cache_format}`, `--samples=${settings.samples}`];
}

function allowing(settings) {
    return settings.allow_problems ? ["--allow-problems"] : [];
}

// A task that runs `blender … --command isochor SUBCOMMAND BLENDFILE …`.
function isochorTask(subcommand, name, settings, args) {
    const task = author.Task(name, "blender");
    const objects = shellSplit(settings.objects || "").map((object) => `--object=${object}`);
    task.addCommand(author.Command("blender-render", {
        exe: "{blender}",
        exeArgs: "{blenderArgs}",
        argsBefore: ["--command", "isochor", subcommand],
        blendfile: settings.blendfile,
        args: args.concat(objects, ["--output", settings.bake_path]),
    }));
    return task;
}

function authorRenders(settings) {
    const scene = settings.scene ? ["--scene", settings.scene] : [];
    return frameChunker(settings.frames, settings.chunk_size).map((chunk) => {
        const task = author.Task(`render-${chunk}`, "blender");
        task.addCommand(author.Command("blender-render", {
            exe: "{blender}",
            exeArgs: "{blenderArgs}",
            argsBefore: [],
            blendfile: bakedFile(settings),
            args: scene.concat([
                "--python-expr", RENDER_SETTINGS,
                "--render-output", settings.render_output_path,
                "--render-format", settings.format,
                "--render-frame", chunk.replace(/-/g, ".."), // Blender's notation of a range
            ]),
        }, frameCount(chunk)));
        return task;
    });
}

// Where the join leaves the blend file that plays from the caches.
function bakedFile(settings) {
    const stem = path.stem(settings.blendfile).replace(".flamenco", "");
    return path.join(settings.bake_path, `${stem}-baked.blend`);
}

// From the first to the last of the frames asked for, such as "3-10": a cache has no gaps.
function wholeRange(settings) {
    const frames = frameChunker(settings.frames, 1);
    return `${frames[0]}-${frames[frames.length - 1]}`;
}

// A chunk of neighbouring frames as FIRST-LAST; Flamenco writes "4" for one and "4,5" for two.
function range(chunk) {
    const frames = chunk.split(/[-,]/);
    return `${frames[0]}-${frames[frames.length - 1]}`;
}
