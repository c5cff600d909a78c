//! A rival that is a program of its own: it reads a mesh as OBJ, and is told by lines of text what to do. So it can be
//! anything that keeps to the protocol in README.md, and nothing of it needs to be here.

use super::super::clock::Spent;
use crate::shape::Shape;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use subsurf::{Boundary, Creasing};

/// A running program that holds one mesh.
pub struct Program {
    child: Child,
    orders: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
    /// Vertices of the level that it refines to.
    pub vertices: usize,
    /// What it says it is.
    pub version: String,
}

impl Program {
    /// Starts the program that the environment variable names with a mesh, a level, and one thread.
    ///
    /// # Errors
    /// "absent" where the variable is not set; what went wrong otherwise.
    pub fn start(variable: &str, mesh: &Path, level: u32) -> Result<Self, String> {
        let name = std::env::var_os(variable).ok_or("absent")?;
        let mut child = Command::new(&name)
            .arg(mesh)
            .arg(level.to_string())
            .env("OMP_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| format!("{}: {e}", Path::new(&name).display()))?;
        let answers = BufReader::new(child.stdout.take().expect("it is piped"));
        let orders = child.stdin.take();
        let mut program = Self { child, orders, answers, vertices: 0, version: String::new() };
        let ready = program.answer()?;
        let mut words = ready.split_whitespace();
        let vertices = words.next().filter(|&w| w == "ready").and_then(|_| words.next()?.parse().ok());
        program.vertices = vertices.ok_or_else(|| format!("says {ready:?} instead of \"ready VERTICES\""))?;
        program.version = words.collect::<Vec<_>>().join(" ");
        Ok(program)
    }

    /// Has it do one piece of work; what that took by its own clocks.
    ///
    /// # Errors
    /// If it ends, or answers something else than two numbers.
    pub fn order(&mut self, work: &str) -> Result<Spent, String> {
        let numbers = self.numbers(work)?;
        match numbers[..] {
            [processor, wall] => Ok(Spent { processor, wall }),
            _ => Err(format!("answers {} numbers to {work}", numbers.len())),
        }
    }

    /// What it answers to an order, as numbers.
    ///
    /// # Errors
    /// If it ends, or answers something else.
    pub fn numbers(&mut self, order: &str) -> Result<Vec<f64>, String> {
        let orders = self.orders.as_mut().expect("kept until the end");
        writeln!(orders, "{order}").map_err(|e| e.to_string())?;
        let answer = self.answer()?;
        let numbers = answer.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>();
        numbers.map_err(|_| answer.trim().to_string())
    }

    fn answer(&mut self) -> Result<String, String> {
        let mut line = String::new();
        match self.answers.read_line(&mut line) {
            Ok(0) => {
                self.orders = None;
                let status = self.child.wait().map_err(|e| e.to_string())?;
                Err(format!("ends: {status}"))
            }
            Ok(_) => Ok(line),
            Err(e) => Err(e.to_string()),
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.orders = None;
        let _ = self.child.wait();
    }
}

/// A file that is removed at the end.
pub struct MeshFile(PathBuf);

impl MeshFile {
    /// Writes a mesh as OBJ with OpenSubdiv's tag lines.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(shape: &Shape) -> Result<Self, String> {
        let file = std::env::temp_dir().join(format!("{}-{}.obj", shape.name, std::process::id()));
        std::fs::write(&file, obj(shape)).map_err(|e| format!("{}: {e}", file.display()))?;
        Ok(Self(file))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for MeshFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn obj(shape: &Shape) -> String {
    let mut text = String::new();
    let mut line = |arguments: std::fmt::Arguments<'_>| {
        let _ = text.write_fmt(arguments);
    };
    shape.positions.iter().for_each(|[x, y, z]| line(format_args!("v {x} {y} {z}\n")));
    let mut start = 0;
    for &sides in &shape.counts {
        line(format_args!("f"));
        shape.indices[start..start + sides as usize].iter().for_each(|v| line(format_args!(" {}", v + 1)));
        line(format_args!("\n"));
        start += sides as usize;
    }
    for c in &shape.tags.creases {
        line(format_args!("t crease 2/1/0 {} {} {}\n", c.vertices[0], c.vertices[1], c.sharpness));
    }
    for c in &shape.tags.corners {
        line(format_args!("t corner 1/1/0 {} {}\n", c.vertex, c.sharpness));
    }
    let rules = shape.tags.rules;
    let boundary = match rules.boundary {
        Boundary::None => 0,
        Boundary::EdgeAndCorner => 1,
        Boundary::EdgeOnly => 2,
    };
    line(format_args!("t interpolateboundary 1/0/0 {boundary}\n"));
    if rules.creasing == Creasing::Chaikin {
        line(format_args!("t creasemethod 0/0/1 chaikin\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_written_as_obj_reads_back_the_same() {
        let text = "v 0 0 0\nv 1 0 0.5\nv 1 1 0\nv 0 1 0\nv 2 2 2\nf 1 2 3 4\nf 3 2 5\nt crease 2/1/0 1 2 2.5\n\
            t corner 1/1/0 0 9\nt interpolateboundary 1/0/0 1\nt creasemethod 0/0/1 chaikin";
        let shape = Shape::parse("catmark_x", text).unwrap();
        let again = Shape::parse("catmark_x", &obj(&shape)).unwrap();
        assert_eq!((&again.positions, &again.counts), (&shape.positions, &shape.counts));
        assert_eq!((&again.indices, &again.tags), (&shape.indices, &shape.tags));
    }

    #[test]
    fn a_program_that_is_not_named_is_absent() {
        let started = Program::start("PEERS_NO_SUCH_VARIABLE", Path::new("x.obj"), 1);
        assert_eq!(started.err().as_deref(), Some("absent"));
    }
}
