// Draws faces by WebGL 2; null where the browser has none.
import { colourOf, Face } from "./scene";

const VERTEX = `#version 300 es
in vec3 place;
in vec3 colour;
uniform vec2 fit;
out vec3 shade;
void main() {
  shade = colour;
  gl_Position = vec4(place.xy * fit, -0.9 * place.z, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision mediump float;
in vec3 shade;
out vec4 seen;
void main() { seen = vec4(shade, 1.0); }`;

export type Draw = (faces: Face[]) => void;

function shader(gl: WebGL2RenderingContext, kind: number, source: string): WebGLShader | null {
  const made = gl.createShader(kind);
  if (!made) return null;
  gl.shaderSource(made, source);
  gl.compileShader(made);
  return gl.getShaderParameter(made, gl.COMPILE_STATUS) ? made : null;
}

export function webglOn(canvas: HTMLCanvasElement): Draw | null {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const program = gl.createProgram(), vertex = shader(gl, gl.VERTEX_SHADER, VERTEX), fragment = shader(gl, gl.FRAGMENT_SHADER, FRAGMENT);
  if (!program || !vertex || !fragment) return null;
  gl.attachShader(program, vertex);
  gl.attachShader(program, fragment);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
  gl.useProgram(program);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  for (const [name, offset] of [["place", 0], ["colour", 12]] as [string, number][]) {
    const at = gl.getAttribLocation(program, name);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 24, offset);
  }
  gl.enable(gl.DEPTH_TEST);
  const fit = gl.getUniformLocation(program, "fit");
  return (faces) => {
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    const numbers: number[] = [];
    for (const { points, paint, light } of faces) {
      const colour = colourOf(paint, light);
      for (let i = 1; i + 1 < points.length; ++i)
        for (const point of [points[0], points[i], points[i + 1]]) numbers.push(...point, ...colour);
    }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const least = Math.min(width, height);
    gl.uniform2f(fit, least / Math.max(1, width), least / Math.max(1, height));
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.DYNAMIC_DRAW);
    gl.drawArrays(gl.TRIANGLES, 0, numbers.length / 6);
  };
}
