import fs from 'node:fs';
import { defineConfig } from 'vite';

// The licences of what is built in travel with it.
const notices = ['three', 'three-mesh-bvh']
  .map((name) => `${name}\n\n${fs.readFileSync(`node_modules/${name}/LICENSE`, 'utf8').trim()}`)
  .join('\n\n----\n\n');

// Four files under fixed names: the program embeds them and serves nothing else; a static host serves them from any folder.
export default defineConfig({
  base: './',
  esbuild: { legalComments: 'inline' },
  build: {
    target: 'es2022',
    modulePreload: false,
    rollupOptions: {
      output: {
        entryFileNames: 'app.js',
        assetFileNames: 'app[extname]',
        inlineDynamicImports: true,
        banner: `/*!\n${notices}\n*/`,
      },
    },
    chunkSizeWarningLimit: 2000,
  },
});
