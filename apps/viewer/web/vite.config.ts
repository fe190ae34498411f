import { defineConfig } from 'vite';

// Three files under fixed names: the program embeds them and serves nothing else.
export default defineConfig({
  build: {
    target: 'es2022',
    modulePreload: false,
    rollupOptions: {
      output: {
        entryFileNames: 'app.js',
        assetFileNames: 'app[extname]',
        inlineDynamicImports: true,
      },
    },
    chunkSizeWarningLimit: 2000,
  },
});
